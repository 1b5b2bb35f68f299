"""`kappamu-studies objects`: models of objects against Monte Carlo, their costs, stated errors and the automatic choice."""
import statistics

from charts.common import MARKS, PlainNumbers, cross, dress, fine_percent, line, panels, percent, provenance, short, table, unique


def objects(record):
    rows = record["rows"]
    answered = [r for r in rows if "refused" not in r]
    models = unique(rows, "model")
    figure, (cost, sizes) = panels(2)
    for number, model in enumerate(models):
        own = [r for r in answered if r["model"] == model]
        line(cost, number, [r["cpu_seconds"] for r in own], [min(r["error"], 10.0) or None for r in own], model,
             style=MARKS[number % len(MARKS)], markerfacecolor="none")
        marble = [r for r in own if "-marble-" in r["name"] and not r["name"].endswith("-sky")]
        across = sorted(unique(marble, "size_over_mean_free_path"))
        of_size = [[r["error"] for r in marble if r["size_over_mean_free_path"] == size] for size in across]
        few = len(marble) < 9 and len(unique(answered, "name")) > 9  # too few shapes for a median
        line(sizes, number, [] if few else across, [statistics.median(errors) or None for errors in of_size], model)
    dress(cost, "every scene", "processor time [s]", "error against Monte Carlo, 2-norm", "xy")
    dress(sizes, "marble: median over the shapes", "longest edge over mean free path",
          "error against Monte Carlo, 2-norm", "xy")
    sizes.xaxis.set_major_formatter(PlainNumbers())
    lines = []
    for name in unique(rows, "name"):
        of_model = {r["model"]: r for r in rows if r["name"] == name}
        some = next((r for r in of_model.values() if "refused" not in r), None)
        cells = ["–"] * 4 if some is None else [short(some["thickness_over_mean_free_path"]), f"{some['albedo']:.4f}",
                                                percent(some["validity_error"], 1), percent(some["reference_error"], 1)]
        for model in models:
            r = of_model.get(model)
            cells.append("" if r is None else "refused" if "refused" in r else
                         f"{percent(r['error'], 1) if r['error'] < 10.0 else 'above 1000 %'} ({r['cpu_seconds']:.3g} s)")
        lines.append([name] + cells)
    head = ["scene", "2V/S, mean free paths", "albedo", "diffusion's error in such a slab", "reference's error"]
    text = (provenance(record) + "\n" + table(["model", "scenes", "median error", "largest", "median s of processor"], [
        [model, len(own), percent(statistics.median(r["error"] for r in own), 1),
         percent(worst, 1) if (worst := max(r["error"] for r in own)) < 10.0 else "above 1000 %",
         f"{statistics.median(r['cpu_seconds'] for r in own):.3g}"]
        for model in models if (own := [r for r in answered if r["model"] == model])])
        + "\nError, and in brackets seconds of processor, of every scene:\n\n" + table(head + models, lines))
    exact = [r for r in answered if "exact_error" in r and r["model"] != "montecarlo"]
    if exact:
        text += "\nAgainst the closed form of diffusion, even diffuse light:\n\n" + table(
            ["scene", "model", "error"], [[r["name"], r["model"], short(r["exact_error"])] for r in exact])
    texts = {"": text}
    if any(r["name"] == THESIS["thin slab"] for r in answered):
        texts["-thesis"] = thesis_table(answered)
    return {"": figure}, texts


def object_costs(record):
    """Seconds against triangles, and against the elements that each model made of them."""
    rows = record["rows"]
    figure, both = panels(2)
    models = unique(rows, "model")
    for number, model in enumerate(models):
        own = [r for r in rows if r["model"] == model]
        for ax, count in zip(both, ("triangles", "elements")):
            line(ax, number, [r[count] for r in own], [r["cpu_seconds"] for r in own], model)
    for ax, count in zip(both, ("triangles", "elements: cubes, panels, triangles, photons")):
        dress(ax, "marble torus of 24 mean free paths", count, "processor time [s]", "xy")
    return {"": figure}, {"": provenance(record) + "\n" + cross(rows, "model", "triangles", lambda r: f"{r['cpu_seconds']:.3g} s")}


# [T] Table 4.1: a marble dragon of 20 mm, one channel, Pentium 4 of 1.7 GHz: seconds in all; no errors are given.
THESIS_SECONDS = {"64³": 16, "128³": 128, "256³": 343}


def refinement(record):
    """Time against error of refined and even cubes, a panel an object."""
    rows = record["rows"]
    names = unique(rows, "name")
    figure, axes = panels(len(names))
    lines = []
    for ax, name in zip(axes, names):
        for number, cubes in enumerate(unique(rows, "cubes")):
            own = [r for r in rows if r["name"] == name and r["cubes"] == cubes]
            line(ax, number, [r["cpu_seconds"] for r in own], [r["error"] for r in own], cubes)
            lines += [[name, cubes, r["asked"], f"{r['elements']:,}", f"{r['cpu_seconds']:.3g}", f"{r['seconds']:.3g}",
                       f"{1e6 * r['cpu_seconds'] / r['elements']:.1f}", fine_percent(r["error"]),
                       fine_percent(r["error_estimate"]) if "error_estimate" in r else "",
                       THESIS_SECONDS.get(r["asked"], "") if cubes == "even at the surface" else ""] for r in own]
        for grid, seconds in THESIS_SECONDS.items():
            ax.axvline(seconds, color="0.6", linestyle=":")
            ax.text(seconds, 0.03, f"[T] {grid} ", rotation=90, color="0.4", ha="right", transform=ax.get_xaxis_transform())
        dress(ax, name, "processor time from mesh to exitance [s]", "error, 2-norm", "xy")
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["object", "cubes", "asked", "number", "processor [s]", "wall [s]", "processor per cube [µs]", "error", "stated", "[T] [s]"],
        lines)}


def estimates(record):
    """The error that cubes state of themselves over the true one, by tolerance and one by one."""
    rows = [r for r in record["rows"] if r["error"] > 1e-9]  # else the reference has the same mesh
    def caution(r):
        return r["error_estimate"] / r["error"]
    lines = []
    for what, own in [(percent(t, 1), [r for r in rows if r["tolerance"] == t]) for t in unique(rows, "tolerance")] + [("all", rows)]:
        of = sorted(map(caution, own))
        lines.append([what, len(own), f"{sum(c >= 1.0 for c in of)} ({sum(c >= 1.0 for c in of) / len(of):.0%})", f"{of[0]:.2f}",
                      f"{statistics.median(of):.2f}", f"{of[-1]:.2f}", sum(r["error"] > r["tolerance"] for r in own)])
    text = provenance(record) + "\n" + table(["tolerance", "answers", "stated at least the true error", "stated over true: least", "median", "most",
                                              "true error above the tolerance"], lines)
    return {}, {"": text + "\n" + table(
        ["scene", "tolerance", "cubes", "processor [s]", "true error", "stated", "stated over true", "reference states"],
        [[r["name"], percent(r["tolerance"], 1), f"{r['elements']:,}", f"{r['cpu_seconds']:.3g}", percent(r["error"], 2),
          percent(r["error_estimate"], 2), f"{caution(r):.2f}", percent(r["reference_error"], 2)] for r in rows])}


def invariances(record):
    """What tessellation and scale change, a row a change."""
    return {}, {"": provenance(record) + "\n" + table(
        ["scene", "change", "triangles", "cubes", "stated error", "exitance changes by"],
        [[r["name"], r["change"], f"{r['triangles']:,}", f"{r['elements']:,}", fine_percent(r["error_estimate"]),
          "" if r["change"].startswith("none") else fine_percent(r["difference"]) if r["difference"] > 1e-5 else short(r["difference"])]
         for r in record["rows"]])}


def pictures(record):
    """Seconds from mesh file to picture."""
    return {}, {"": provenance(record) + "\n" + table(
        ["object", "tolerance", "cubes", "cubes of an even 256³", "stated error", "wall, all [s]", "file and checks", "light", "model", "picture",
         "linear systems, per channel"],
        [[r["name"], percent(r["tolerance"], 2), f"{r['elements']:,}", f"{r['cubes_of_256']:,}", percent(r["error_estimate"], 2), f"{r['seconds']:.1f}"]
         + [f"{r[k]:.1f}" for k in ("scene_seconds", "light_seconds", "model_seconds", "picture_seconds")]
         + [f"{r['seconds_per_light']:.2f}"] for r in record["rows"]])}


# [T] Table 5.1: its objects, of 20 to 40 mm in marble, and here of 33 mm (72 mean free paths of the red channel).
THESIS = {"half-space (thick slab)": "slab-marble-72", "sphere": "sphere-marble-72", "cube": "cube-marble-72",
          "thin slab": "thin-slab-marble-72", "torus": "torus-marble-72", "box with a void": "box-with-void-marble-72",
          "cube split in two": "split-cube-marble-72", "cube, light from everywhere": "cube-marble-72-sky"}

THESIS_MODELS = ("dipole-rotated", "boundary_integral", "embedded")


def thesis_table(answered):
    models = [m for m in THESIS_MODELS if any(r["model"] == m for r in answered)]
    lines = []
    for title, name in THESIS.items():
        own = {r["model"]: r for r in answered if r["name"] == name}
        if not own:
            continue
        some = next(iter(own.values()))
        lines.append([title, short(some["thickness_over_mean_free_path"]), percent(some["reference_error"], 1)]
                     + [f"{percent(own[m]['error'], 1)} ({own[m]['cpu_seconds']:.3g} s)" if m in own else "" for m in models])
    return table(["[T] Table 5.1", "2V/S, mean free paths", "reference's error"] + models, lines)


def automatic(record):
    """What model auto took, over all scenes and one by one."""
    rows = record["rows"]
    lines = []
    for tolerance in unique(rows, "tolerance"):
        own = [r for r in rows if r["tolerance"] == tolerance]
        said = [r for r in own if r["within_tolerance"]]
        met = [r for r in said if r["met"]]
        ratios = sorted(r["cost_ratio"] for r in met if r["cost_ratio"])
        over = [r["error"] / tolerance for r in said if not r["met"]]
        taken = ", ".join(f"{model} {sum(r['model'] == model for r in own)}" for model in unique(own, "model")) + (
            f", corrected {sum(r['corrected'] for r in own)}")
        lines.append([percent(tolerance), len(own), f"{len(met)} of {len(said)}", f"{max(over):.2g}" if over else "–",
                      f"{statistics.median(ratios):.2g}" if ratios else "–", f"{max(ratios):.2g}" if ratios else "–",
                      sum(ratio > 3.0 for ratio in ratios), taken])
    text = provenance(record) + "\n" + table(
        ["tolerance", "scenes", "met, of those said to be", "error over tolerance where not, most",
         "cost over the cheapest that met it: median", "most", "above 3", "taken"], lines)
    text += "\n" + table(
        ["scene", "tolerance", "taken", "corrected by", "error expected", "error", "s of processor", "cheapest that met it", "cost ratio"],
        [[r["name"], percent(r["tolerance"]),
          r["model"], f"{r['pilot_photons']} photons" if r["corrected"] else "", percent(r["expected_error"], 1),
          percent(r["error"], 1) + ("" if r["met"] else " (above)"), f"{r['cpu_seconds']:.2g}", r["cheapest"] or "none",
          "–" if r["cost_ratio"] is None else f"{r['cost_ratio']:.2g}"] for r in rows])
    return {}, {"": text}

"""`kappamu-studies inverse` and `uncertainty`."""
import math
import statistics

from charts.common import COLOURS, MARKS, cross, dress, line, panels, percent, provenance, table, unique
from charts.forward import grid_name


def first_to_reach(course, error):
    return next((point for point in course if point["validation_E"] <= error), None)


def against_default(ours, other):
    """The best E of `other`, its solves and work there over those of the default, and its solves at its end over those
    of the default at that E: a fixed weight may end above its best."""
    best = min(point["validation_E"] for point in other["course"])
    theirs, mine = first_to_reach(other["course"], best), first_to_reach(ours["course"], best)
    at_end = first_to_reach(ours["course"], other["validation_E"])
    return [f"{best:.1e}", f"{theirs['solves'] / mine['solves']:.1f}" if mine else "never there",
            f"{theirs['work'] / mine['work']:.1f}" if mine else "",
            f"{other['batched_solves'] / at_end['solves']:.1f}" if at_end else ""]


def optimisers(record):
    rows = record["rows"]
    noises = unique(rows, "noise")
    figure, axes = panels(2 * len(noises), 2, 7, 4)
    lines = []
    for k, noise in enumerate(noises):
        some = [r for r in rows if r["noise"] == noise]
        for ax, key, label in ((axes[2 * k], "seconds", "seconds"),
                               (axes[2 * k + 1], "work", "work: iterations of the fitted grid, 16 patterns each")):
            for number, r in enumerate(some):
                line(ax, number, [p[key] for p in r["course"]], [p["validation_E"] for p in r["course"]],
                     r["label"], markersize=3)
            dress(ax, f"noise {100 * noise:g} %", label, "E under 8 × 8 validation patterns", "xy", "upper right")
        for r in some:
            lines.append([f"{100 * noise:g} %", r["label"], f"{r['validation_E']:.1e}",
                          f"{r['single_voxel_E']:.1e}", f"{r['data_misfit_chi2']:.2f}", r["batched_solves"],
                          f"{r['work']:.0f}", f"{r['seconds']:.1f}"]
                         + (["", "", "", ""] if r is some[0] else against_default(some[0], r)))
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["noise", "variant", "E, 8 × 8 patches", "E, single voxels", "χ²", "solves", "work", "seconds", "its best E",
         "solves there over ours there", "work there over ours there", "solves at its end over ours at that E"], lines)}


def scores(record):
    figure, axes = panels(2)
    lines = []
    for number, (light, noise) in enumerate(unique(record["rows"], lambda r: (r["variant"], r["noise"]))):
        some = [r for r in record["rows"] if (r["variant"], r["noise"]) == (light, noise)]
        both = lambda key: [f([r[key] for r in some]) for f in (statistics.median, max)]
        lines.append([light, f"{100 * noise:g} %", len(some)]
                     + ["{:.1e}, {:.1e}".format(*both(key)) for key in ("validation_E", "single_voxel_E")]
                     + [f"{both('data_misfit_chi2')[1]:.2f}", f"{both('batched_solves')[0]:.0f}",
                        f"{both('work')[0]:.0f}"])
        for ax, key in zip(axes, ("kappa_error_by_depth", "mu_error_by_depth")):
            depths = list(zip(*(r[key] for r in some)))
            line(ax, number, range(1, len(depths) + 1), [statistics.median(d) for d in depths],
                 f"{light}, noise {100 * noise:g} %")
    for ax, name in zip(axes, "κμ"):
        dress(ax, f"error of {name} by depth", "layer, 1 = lit face", "median |found/true - 1|, median over truths",
              "y", "outside")
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["light", "noise", "truths", "E, 8 × 8 patches: median, worst", "E, single voxels: median, worst", "χ², worst",
         "solves, median", "work, median"], lines)}


def patterns(record):
    figure, axes = panels(2)
    rows = sorted(record["rows"], key=lambda r: r["patterns"])
    middles, curves = [], {}
    for variant, images in unique(rows, lambda r: (r["variant"], r["patterns"])):
        some = [r for r in rows if (r["variant"], r["patterns"]) == (variant, images)]
        middle = lambda value: statistics.median(value(r) for r in some)
        errors = [middle(lambda r: r[key]) for key in ("validation_E", "single_voxel_E")]
        changes = [percent(middle(lambda r: statistics.median(r[key])))
                   for key in ("kappa_error_by_depth", "mu_error_by_depth")]
        curves.setdefault(variant, []).append((images, *errors))
        middles.append({"images": images, "light": variant,
                        "cell": ", ".join(f"{e:.1e}" for e in errors) + "; " + ", ".join(changes)})
    for k, (ax, name) in enumerate(zip(axes, ("8 × 8 patches", "single voxels"))):
        for number, (variant, points) in enumerate(curves.items()):
            line(ax, number, [p[0] for p in points], [p[k + 1] for p in points], variant)
        dress(ax, f"E under {name}, noise 1 %", "images", "E, median", "xy")
    return {"": figure}, {"": provenance(record) + "\nE under 8 × 8 patches, of single voxels; error of κ, of μ:\n\n"
                          + cross(middles, "images", "light", lambda r: r["cell"])}


def voxels(record):
    figure, axes = panels(2, 2, 6, 4.4)
    cells = [math.prod(r["grid"]) for r in record["rows"]]
    for ax, key, title, label in ((axes[0], "seconds", "one channel, 16 patterns, noise 1 %", "seconds"),
                                  (axes[1], "batched_solves", "cost in solves", "batched solves, all grids")):
        line(ax, 0, cells, [r[key] for r in record["rows"]], "_")
        dress(ax, title, "voxels", label, "xy")
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["grid", "seconds", "solves", "work", "microseconds per voxel", "E, 8 × 8 patches"],
        [[grid_name(r["grid"]), f"{r['seconds']:.1f}", r["batched_solves"], f"{r['work']:.0f}",
          f"{1e6 * r['seconds'] / n:.0f}", f"{r['validation_E']:.1e}"] for n, r in zip(cells, record["rows"])])}


def samples(record):
    hours = {"wax1": 2, "wax2": 4, "marble": 11, "stone": 3}  # [W] Table II
    return {}, {"": provenance(record) + "\n" + table(
        ["sample", "voxels", "paper [h]", "ours, to volumes [s]", "their deviations [s]", "solves", "E of R, G, B", "χ²"],
        [[r["sample"], " × ".join(str(n) for n in r["grid"]), hours[r["sample"]], f"{r['seconds']:.0f}",
          f"{r['deviation_seconds']:.0f}", r["batched_solves"], ", ".join(f"{e:.1e}" for e in r["validation_E"]),
          ", ".join(f"{c:.2f}" for c in r["data_misfit_chi2"])] for r in record["rows"]]),
        "-coverage": table(
            ["sample", "κ within two deviations (worst layer), R, G, B", "μ"],
            [[r["sample"], *(", ".join(f"{100 * c['all']:.0f} ({100 * c['worst_layer']:.0f})" for c in r[what]) + " %"
                             for what in ("kappa_coverage", "mu_coverage"))] for r in record["rows"]])}


def ablations(record):
    rows = record["rows"]
    mean_error = "kappa_error_by_depth"
    middle = lambda some, value: statistics.median(value(r) for r in some)
    figure, axes = panels(2)
    for number, variant in enumerate(unique(rows, "variant")):
        curve = [(noise, [r for r in rows if r["variant"] == variant and r["noise"] == noise])
                 for noise in unique(rows, "noise")]
        line(axes[0], number, [c[0] for c in curve], [middle(c[1], lambda r: r["validation_E"]) for c in curve], variant)
        line(axes[1], number, [c[0] for c in curve],
             [middle(c[1], lambda r: statistics.mean(r[mean_error])) for c in curve], variant)
    dress(axes[0], "", "noise, relative", "E under 8 × 8 validation patterns", "xy", "outside")
    dress(axes[1], "", "noise, relative", "median error of κ", "xy", "outside")
    noises = unique(rows, "noise")
    lines = []
    for variant in unique(rows, "variant"):
        lines.append([variant])
        for noise in noises:
            some = [r for r in rows if r["variant"] == variant and r["noise"] == noise]
            worst = max(r["validation_E"] for r in some)
            lines[-1].append(f"{middle(some, lambda r: r['validation_E']):.2e} ({worst:.2e}), "
                             f"{middle(some, lambda r: r['single_voxel_E']):.2e}, "
                             + percent(middle(some, lambda r: statistics.mean(r[mean_error])), 1))
    text = "E under 8 × 8 patches, median (worst), median E of single voxels and error of κ, at each noise:\n\n"
    return {"": figure}, {"": text + table(["variant"] + [f"{100 * noise:g} %" for noise in noises], lines)}


def coverage(record):
    """Shares within two deviations, pooled over the truths of a family: of all voxels (at the seen face), and how far
    the mean errors of whole layers are from what is stated."""
    rows = record["rows"]
    families = unique(rows, "family")

    def cells(some, what):
        layers = range(len(some[0][what]["within"]))
        share = [statistics.mean(r[what]["within"][k] for r in some) for k in layers]
        off = [math.sqrt(statistics.mean((r[what]["error"][k] / r[what]["stated"][k]) ** 2 for r in some)) for k in layers]
        error = [statistics.mean(r[what]["error"][k] for r in some) for k in layers]
        return [f"{percent(statistics.mean(share))} ({percent(share[-1])})", f"{off[0]:.1f}, {off[-1]:.1f}",
                f"{100 * error[0]:+.0f}, {100 * error[-1]:+.0f} %"]

    lines = []
    for noise in unique(rows, "noise"):
        for family in families + ["all"]:
            some = [r for r in rows if r["noise"] == noise and family in (r["family"], "all")]
            lines.append([percent(noise, 1), family, len(some), *cells(some, "kappa"), *cells(some, "mu")])
    head = ["noise", "truths", "blocks"]
    for name in ("κ", "μ"):
        head += [f"{name} within two (seen face)", f"{name}: error of a layer's mean over stated, rms, lit and seen face",
                 f"{name}: its mean, lit and seen face"]
    return {}, {"": provenance(record) + "\n" + table(head, lines)}


def uncertainty(record):
    figure, axes = panels(2, 2, 7, 6)
    for ax, chart in zip(axes, record["scatter"]):
        both = []
        for number, (key, name) in enumerate((("log_kappa", "log κ"), ("log_mu", "log μ"))):
            predicted, sampled = chart.get(key, {}).get("predicted", []), chart.get(key, {}).get("sampled", [])
            both += predicted
            ax.plot(predicted, sampled, MARKS[number], color=COLOURS[number], markerfacecolor="none", label=name)
        for factor in (0.75, 1.0, 1.25):
            ends = [min(both), max(both)]
            ax.plot(ends, [factor * e for e in ends], "--", color=COLOURS[7],
                    label="equal, ± 25 %" if factor == 1 else "_")
        dress(ax, chart["title"], "predicted standard deviation [log units]",
              "sampled standard deviation [log units]", "xy", "upper left")
    text = "\n".join(table([part, "solves", "unknowns", "5 %", "median", "95 %"],
                           [[r["method"], r["batched_solves"] or "", r["unknowns"]]
                            + [f"{r[key]:.2f}" for key in ("ratio_5", "ratio_median", "ratio_95")]
                            for r in record["rows"] if r["part"] == part]) for part in unique(record["rows"], "part"))
    return {"": figure}, {"": text}

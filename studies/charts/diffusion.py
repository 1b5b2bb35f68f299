"""`kappamu-studies validity` and `slabs`: where diffusion holds."""
import math
import statistics

import matplotlib.pyplot as plt

from charts.common import COLOURS, GREY, MARKS, dress, panels, percent, short, table, unique


def validity(record):
    rows = record["rows"]
    # From blue to red, distinguishable in grey and by the colour-blind; grey where noise hides the error.
    bands = [(0.01, "#4393C3", "below 1 %"), (0.03, "#A6D3E8", "1 to 3 %"), (0.1, "#FDDBA0", "3 to 10 %"),
             (math.inf, "#E08060", "above 10 %")]
    unresolved = "#DDDDDD"
    albedos, thicknesses = unique(rows, "albedo"), unique(rows, "mean_free_paths")
    figure, axes = panels(4, 2, 5.9, 4.3)
    for ax, (key, title, form) in zip(axes, (
            ("reflected", "reflected total, diffusion / Monte Carlo - 1 [%]", "{:+.1f}"),
            ("transmitted", "transmitted total, diffusion / Monte Carlo - 1 [%]", "{:+.1f}"),
            ("lit_map", "lit face under a patch, relative L2 error [%]", "{:.1f}"),
            ("far_map", "far face under a patch, relative L2 error [%]", "{:.1f}"))):
        for r in rows:
            x, y, e = thicknesses.index(r["mean_free_paths"]), albedos.index(r["albedo"]), r[key]
            colour = unresolved if e is None else next(c for below, c, _ in bands if abs(e) < below)
            ax.add_patch(plt.Rectangle((x - 0.49, y - 0.48), 0.98, 0.96, color=colour, linewidth=0))
            ax.text(x, y, "-" if e is None else form.format(100 * e), ha="center", va="center")
        ax.grid(False)
        ax.set(title=title, xlabel="thickness [transport mean free paths]", ylabel=r"albedo $\sigma_s'$ / ($\sigma_s'$ + μ)",
               xticks=range(len(thicknesses)), xticklabels=[f"{t:g}" for t in thicknesses],
               yticks=range(len(albedos)), yticklabels=[f"{a:g}" for a in albedos],
               xlim=(-0.5, len(thicknesses) - 0.5), ylim=(-0.5, len(albedos) - 0.5))
    figure.legend(handles=[plt.Rectangle((0, 0), 1, 1, color=colour, label=label) for _, colour, label in bands]
                  + [plt.Rectangle((0, 0), 1, 1, color=unresolved, label="below the noise of Monte Carlo")],
                  loc="lower left", ncol=5, frameon=False, bbox_to_anchor=(0.04, -0.04))
    listed = lambda values: ", ".join(f"{v:g}" for v in values)
    error = lambda e: "{}" if e is None else f"{e:.3g}"
    include = ("// Written by studies/bench_charts.py: do not edit. Errors of diffusion against transport, relative;\n"
               "// {} where Monte Carlo does not resolve them.\n"
               f"constexpr std::array<double, {len(albedos)}> table_albedo{{{listed(albedos)}}};\n"
               f"constexpr std::array<double, {len(thicknesses)}> table_thickness{{{listed(thicknesses)}}};\n"
               "// reflected, transmitted, far_map of [albedo][thickness]\n"
               f"constexpr std::array<ValidityEstimate, {len(rows)}> table_error{{{{\n"
               + "".join("    {" + ", ".join(error(r[k]) for k in ("reflected", "transmitted", "far_map")) + "},\n"
                         for r in rows) + "}};\n")
    return {"": figure}, {"_table.inc": include}


def fitted_slabs(rows):
    """Found over published coefficients by file: medians by both equations, and transport's own deviations."""
    names = ("sigma_a", "sigma_s'")
    stds = ("log_sigma_a_std", "log_sigma_s_std")
    lines = []
    for file in unique(rows, "file"):
        fits = [r["fitted"] for r in rows if r["file"] == file]
        off = lambda model, name: [abs(f[model][f"{name} over published"] - 1) for f in fits]
        within = [abs(math.log(f["transport"][f"{name} over published"])) < 2 * f["transport"][std]
                  for f in fits for name, std in zip(names, stds)]
        transport = [f["transport"] for f in fits]
        lines.append([file, len(fits)] + [percent(statistics.median(off(model, name)), 1)
                                          for name in names for model in ("diffusion", "transport")]
                     + [", ".join(percent(statistics.median(t[std] for t in transport), 1) for std in stds),
                        f"{sum(within)} of {len(within)}", f"{statistics.median(t['refreshes'] for t in transport):g}",
                        f"{sum(t['settled'] for t in transport)}"])
    return table(["file", "rows", "μ by diffusion", "by transport", "σs' by diffusion", "by transport",
                  "deviations stated, μ and σs'", "values within two", "renewals of r", "rows settled"], lines)


def slabs(record):
    materials = {"510nm_phantom": "phantom", "il_A": "Intralipid", "ink_A": "ink", "kenlee_A": "TiO2",
                 "royston1": "ink", "tio2_vis": "TiO2 phantom"}
    label = lambda file: f"{materials[file]} ({file})" if file in materials else file
    rows = record["slabs"]
    models = (("diffusion", "diffusion"), ("monte_carlo", "Monte Carlo"))
    figure, axes = panels(6, 2, 6.4, 4.6)
    for k, (model, name) in enumerate(models):
        for c, (what, title) in enumerate((("M_R", "total reflectance"), ("M_T", "total transmittance"))):
            ax = axes[2 * k + c]
            for number, file in enumerate(unique(rows, "file")):
                some = [r for r in rows if r["file"] == file]
                ax.plot([r["measured"][what] for r in some], [r[model][what] for r in some],
                        MARKS[number % len(MARKS)], color=COLOURS[number], markerfacecolor="none", label=label(file))
            ax.plot([0, 0.9], [0, 0.9], color=GREY, label="equal")
            dress(ax, f"{title} by {name}", "measured, share of incident light", "predicted", "", "upper left")
            ax.set(xlim=(0, 0.9), ylim=(0, 0.9))
    for ax, what, title in ((axes[4], "M_R", "reflectance"), (axes[5], "M_T", "transmittance")):
        for number, (model, name) in enumerate(reversed(models)):
            ax.plot([1 - r["albedo"] for r in rows], [r[model][what] - r["measured"][what] for r in rows],
                    MARKS[number], color=COLOURS[number], markerfacecolor="none", label=name)
        dress(ax, f"{title}: where diffusion holds", "absorbed share of collisions, 1 - albedo",
              "predicted - measured", "x", "upper left")
        ax.set_xlim(5e-4, 1.2)
    texts = {"-fit": fitted_slabs(rows)} if rows[0].get("fitted") else {}
    return {"": figure}, texts | {"": table(
        ["file", "rows", "albedo σs'/(σs'+μ)", "mean free paths", "diffusion M_R", "M_T", "Monte Carlo M_R", "M_T"],
        [[r["file"], r["rows"], f"{r['albedo from']:.2g} to {r['albedo to']:.2g}",
          f"{r['mean free paths from']:.2g} to {r['to']:.2g}"]
         + [short(r[f"{model} {what}"]) for model, _ in models for what in ("M_R", "M_T")] for r in record["rows"]])}

#!/usr/bin/python3
"""Charts and tables of the records that `kappamu bench` wrote.

    scripts/bench_charts.py FOLDER              draws FOLDER/<record>.png and writes FOLDER/<record>.md
    scripts/bench_charts.py FOLDER PAGE.md...   also renews the pages: the text between `<!-- bench:<record> -->`
                                                and `<!-- /bench -->`, and the pictures in images/ beside them

A record that was not measured leaves its place as it is. Needs Debian's python3-matplotlib.
"""
import json
import math
import os
import pathlib
import re
import statistics
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
from matplotlib.collections import PolyCollection
from matplotlib.ticker import LogFormatter

# Okabe and Ito's palette (2008), distinguishable by colour-blind readers, and four darker colours.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D00",
           "#7F3C8D", "#666666", "#A50026", "#2F6B3A"]
MARKS = "sov^D<>phX"
GREY = COLOURS[9]
plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.color": "#d8d8d8", "axes.titlesize": 10,
                     "axes.axisbelow": True, "legend.fontsize": 8, "lines.linewidth": 1.5, "lines.markersize": 5})


# ---- Texts and tables

def short(value):
    """Two significant digits; 1e-06 reads 1e-6."""
    if value is None:
        return "–"
    if not isinstance(value, float):
        return str(value)
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m.group(1).replace("+", "") + m.group(2), f"{value:.2g}")


def percent(share, digits=0):
    return "–" if share is None else f"{100 * share:.{digits}f} %"


def fine_percent(share):
    return percent(share, 2 if share < 0.00995 else 1 if share < 0.0995 else 0)


FOLDED = 20  # rows: a longer table is folded


def table(head, rows):
    lines = [head, ["---"] * len(head)] + [list(row) for row in rows]
    text = "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)
    text = text.replace("| --- " * len(head) + "|", "|---" * len(head) + "|")
    count = len(lines) - 2
    return text if count <= FOLDED else f"<details><summary>{count} rows</summary>\n\n{text}\n</details>\n"


def flat(rows, names, formats=None):
    formats = formats or {}
    return table(names, [[formats.get(name, short)(row.get(name)) for name in names] for row in rows])


def cross(rows, line, column, cell):
    """A line for each value of `line`, a column for each of `column`; both are keys or functions of a row."""
    at = [key if callable(key) else (lambda row, key=key: short(row[key])) for key in (line, column)]
    name = [key.__doc__ if callable(key) else key for key in (line, column)]
    cells = {(at[0](row), at[1](row)): cell(row) for row in rows}
    columns = unique(rows, at[1])
    return table([name[0]] + [f"{name[1]} {c}" for c in columns],
                 [[label] + [cells.get((label, c), "") for c in columns] for label in unique(rows, at[0])])


def unique(rows, key):
    return list(dict.fromkeys(key(row) if callable(key) else row[key] for row in rows))


def provenance(record):
    machine, program = record["machine"], record["program"]
    device = next((row["device"] for row in record.get("rows", []) if "device" in row), record["device"])
    size = {"full": "", "small": "; the small form of the command", "quick": "; QUICK form, toy problems"}[record["size"]]
    return (f"Measured on {machine['cpu']}, {machine['cores']} cores, copy "
            f"{machine['copy_bandwidth_bytes_per_second'] / 1e9:.1f} GB/s, load {machine['load']:.1f} before; "
            f"device {device}; kappamu {program['kappamu']}, {program['compiler']}, {program['build']}{size}.\n")


# ---- Charts

class PlainNumbers(LogFormatter):
    """0.3, not 3e-1, at the ticks of a logarithmic axis."""

    def _num_to_string(self, x, vmin, vmax):
        return f"{x:g}"


def panels(count, columns=2, width=7.0, height=4.4):
    columns = min(columns, count)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False,
                                constrained_layout=True)
    for unused in axes.flat[count:]:
        unused.set_visible(False)
    return figure, list(axes.flat[:count])


def dress(ax, title, x_label, y_label, log="", legend="best"):
    ax.set(title=title, xlabel=x_label, ylabel=y_label)
    for name, axis in (("x", ax.xaxis), ("y", ax.yaxis)):
        if name in log:
            ax.set(**{name + "scale": "log"})
            low, high = axis.get_view_interval()
            if high < 100 * low:  # within two decades plain numbers are easier to read than powers
                axis.set_major_formatter(PlainNumbers())
                axis.set_minor_formatter(PlainNumbers(minor_thresholds=(2, 0.5)))
    if not any(len(line.get_xdata()) for line in ax.lines):
        raise SystemExit(f"bench_charts: chart '{title}' has no point to draw")
    if any(not line.get_label().startswith("_") for line in ax.lines):
        if legend == "outside":
            ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
        else:
            ax.legend(loc=legend)


def line(ax, number, x, y, label, style="-", **options):
    """Line and marks of the number's colour; dashes and dots have no marks."""
    mark = {"marker": MARKS[number % len(MARKS)], "markerfacecolor": "none"} if style == "-" else {}
    points = [(a, b) for a, b in zip(x, y) if b is not None and math.isfinite(b)]
    ax.plot([p[0] for p in points], [p[1] for p in points], style, color=COLOURS[number % len(COLOURS)],
            label=label, **{**mark, **options})


# ---- kappamu bench forward

def grid_name(grid):
    return "x".join(str(n) for n in grid)


def problem_title(problem):
    background, whole = problem["background_contrast"], problem["contrast"]
    inclusions = math.sqrt(whole / background)
    return (f"{problem['name']}: {grid_name(problem['grid'])}, {problem['patterns']} patterns, contrast "
            + (f"{background:g} with inclusions ×{inclusions:g} and ÷{inclusions:g}" if background > 1
               else f"{whole:g}"))


def solver_label(sample):
    names = {"multigrid": f"kappamu, {sample['precision']}", "reference": "kappamu's serial reference"}
    return names.get(sample["method"], sample["method"])


def reached(samples, label):
    """Seconds of the cheapest sample within each error, the least error and the set-up, of each solver."""
    bounds, lines = (1e-2, 1e-4, 1e-6), []
    for name in unique(samples, label):
        own = [s for s in samples if label(s) == name]
        within = [min((s["seconds_per_rhs"] for s in own if s["true_error"] <= bound), default=None) for bound in bounds]
        lines.append([name] + ["–" if w is None else f"{w:.4f}" for w in within]
                     + [f"{min(s['true_error'] for s in own):.1e}", f"{own[0]['set_up_seconds']:.3f}"])
    return table(["method", "seconds per right-hand side to a true error of 1e-2", "1e-4", "1e-6", "least error",
                  "set-up [s]"], lines)


def time_error(record):
    runs = record["runs"]
    figure, axes = panels(len(runs), 2, 9.5, 5.6)
    text = provenance(record) + "\n"
    for ax, run in zip(axes, runs):
        samples = run["samples"]
        label = lambda s: solver_label(s) + ("" if s["error_of"] == "phi" else " (maps)")
        for number, name in enumerate(unique(samples, label)):
            some = [s for s in samples if label(s) == name]
            line(ax, number, [s["true_error"] for s in some], [s["seconds_per_rhs"] for s in some], name)
        dress(ax, problem_title(run["problem"]), "true error: relative L2 distance to the converged solution, "
              "worst pattern", "seconds per right-hand side", "xy", "outside")
        ax.set_xlim(2, 1e-12)
        text += (f"**{problem_title(run['problem'])}**; the converged solution is known to "
                 f"{run['problem']['truth_error']:.0e}.\n\n" + reached(samples, label) + "\n")
    return {"": figure}, {"": text}


def peers(record):
    figures, texts = time_error(record)
    run = record["runs"][0]
    compared = run["comparison"]
    texts[""] += (f"Single precision attains {compared['single_precision_floor']:.1e} at best, so methods meet at a "
                  f"true error of {compared['target_error']:.0e}.\n\n")
    texts[""] += table(["solver", "seconds per right-hand side, set-up shared by all patterns", "set-up paid by one",
                        "ratio to ours, shared", "unshared set-up"],
                       [[solver_label(s)] + (["not reached", "", "", ""] if s["seconds"] is None else
                                             [f"{s['seconds']:.4f}", f"{s['unshared_seconds']:.4f}",
                                              f"{s['ratio']:.1f}", f"{s['unshared_ratio']:.1f}"])
                        for s in compared["solvers"]]) + "\n"
    for name, peer in run.get("peers", {}).items():
        texts[""] += (f"- {name}, {peer['ranks']} ranks, settings tried on one pattern at residual 1e-6: "
                      + "; ".join(peer["tried"]) + ".\n")
    return figures, texts


def headline(record):
    figures, texts = time_error(record)
    for claim in record["runs"][0]["relaxation"]:
        bound = claim["ratio_is_lower_bound"]
        texts[""] += (f"- {claim['method']}: {'more than ' if bound else ''}{claim['ratio']:.0f} times our time at a "
                      f"true error of 1e-2 ({claim['ours_seconds_per_rhs']:.4f} s)"
                      + (f"; after {claim['last_seconds']:.1f} s per right-hand side its error is still "
                         f"{claim['last_error']:.2f}.\n" if bound else ".\n"))
    return figures, texts


def kernels(record):
    target = 0.6  # of the copy bandwidth, for kernels on the finest grid
    text = ""
    for run in record["runs"]:
        text += f"**{problem_title(run['problem'])}**, {provenance(record)}\n"
        for profile in run["profiles"]:
            solve = profile["solve_seconds"]
            finest = sum(use["seconds_per_solve"] for use in profile["kernels"])
            share = lambda seconds: f"{100 * seconds / solve:.0f} %"
            rows, slow = [], []
            for use in profile["kernels"]:
                one, bytes_moved = use["seconds_per_launch"], use.get("bytes_per_launch")
                row = [use["kernel"], f"{use['launches_per_solve']:.3g}", f"{1e3 * one:.2f}",
                       share(use["seconds_per_solve"])]
                rows.append(row + (["not stated", "", ""] if bytes_moved is None else
                                   [f"{1e-6 * bytes_moved:.0f}", f"{1e-9 * bytes_moved / one:.1f}",
                                    percent(use["bandwidth_fraction"])]))
                if use.get("bandwidth_fraction", 1) < target:
                    slow.append(use["kernel"])
            rows += [["all of these", "", "", share(finest), "", "",
                      f"**{percent(profile['finest_bandwidth_fraction'])}**"],
                     ["coarser grids and sums", "", "", share(profile["coarse_seconds"]), "", "", ""],
                     ["outside kernels", "", "", share(max(0, solve - finest - profile["coarse_seconds"])), "", "", ""]]
            text += (f"**{profile['precision']} precision**: {profile['iterations']} iterations, {solve:.3f} s a solve; "
                     f"copy bandwidth {1e-9 * profile['copy_bandwidth_bytes_per_second']:.1f} GB/s.\n\n"
                     + table(["kernel, finest grid", "launches", "one [ms]", "all, share of the solve",
                              "must move [MB]", "GB/s", "of copy bandwidth"], rows)
                     + f"\n{'Below' if slow else 'All are above'} {percent(target)}"
                     + f"{': ' if slow else ''}{', '.join(slow)}.\n\n")
    return {}, {"": text}


def scaling(record):
    figure, (time, count) = panels(2)
    rows = []
    samples = [(math.prod(run["problem"]["grid"]), grid_name(run["problem"]["grid"]), s)
               for run in record["runs"] for s in run["samples"]]
    for number, method in enumerate(unique(samples, lambda s: s[2]["method"])):
        some = [s for s in samples if s[2]["method"] == method]
        cells, seconds = [s[0] for s in some], [s[2]["seconds_per_rhs"] for s in some]
        label = solver_label(some[0][2])
        if number == 0:
            time.plot(cells, [seconds[-1] * n / cells[-1] for n in cells], "--", color=GREY,
                      label="proportional to unknowns")
        line(time, number, cells, seconds, label)
        line(count, number, cells, [s[2]["iterations"] for s in some], label)
        rows += [[grid, label, s["iterations"], f"{s['seconds_per_rhs']:.5f}",
                  f"{1e9 * s['seconds_per_rhs'] / n:.1f}", f"{s['true_error']:.1e}"] for n, grid, s in some]
    dress(time, "Cost against unknowns, cubes with inclusions, residual 1e-6, 16 patterns",
          "unknowns per right-hand side", "seconds per right-hand side", "xy")
    dress(count, "Iterations against unknowns", "unknowns per right-hand side",
          "iterations of the slowest pattern", "x")
    count.set_ylim(0)
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["grid", "method", "iterations", "per right-hand side [s]", "per unknown [ns]", "true error"], rows)}


# ---- kappamu bench inverse

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


def monte_carlo(record):
    rows = record["rows"]
    figure, axes = panels(2)
    lines = []
    for ax, name, key in zip(axes, "κμ", ("kappa_error_by_depth", "mu_error_by_depth")):
        for number, row in enumerate(rows):
            line(ax, number, range(1, len(row[key]) + 1), row[key], f"by {row['variant']}")
        dress(ax, f"{name}, data from Monte Carlo", "layer, 1 = lit face", "median |found/true - 1|", "y")
    for row in rows:
        seen = [", ".join(percent(d) for d in row[key][-1:-3:-1]) for key in ("kappa_error_by_depth", "mu_error_by_depth")]
        lines.append([grid_name(row["grid"]), percent(row["noise"]), row["variant"], f"{row['data_misfit_chi2']:.2f}",
                      f"{row['validation_E']:.1e}"] + seen +
                     [f"{row['photons']:.1e}", row["renewals"], f"{row['seconds']:.0f}"])
    return {"": figure}, {"": provenance(record) + f"\nThe true coefficients under diffusion: E = {rows[0]['truth_E']:.1e}.\n" + table(
        ["grid", "noise", "fitted by", "χ²", "E", "κ error, two layers at the seen face", "μ error",
         "photons", "solves on the finer grid", "seconds"], lines)}


def samples(record):
    hours = {"wax1": 2, "wax2": 4, "marble": 11, "stone": 3}  # [W] Table II
    return {}, {"": provenance(record) + "\n" + table(
        ["sample", "voxels", "paper [h]", "ours, to volumes [s]", "their deviations [s]", "solves", "E of R, G, B", "χ²"],
        [[r["sample"], " × ".join(str(n) for n in r["grid"]), hours[r["sample"]], f"{r['seconds']:.0f}",
          f"{r['deviation_seconds']:.0f}", r["batched_solves"], ", ".join(f"{e:.1e}" for e in r["validation_E"]),
          ", ".join(f"{c:.2f}" for c in r["data_misfit_chi2"])] for r in record["rows"]])}


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


# ---- Calibration and frames

def calibration(record):
    rows = record["rows"]
    figure, axes = panels(2, 2, 6.2, 4.2)
    for ax, title, label, found, stated, factor in (
            (axes[0], "camera calibration: error over the frame, at the sample's distance", "RMS [px]", "error_px",
             "predicted_px", 1), (axes[1], "focal length", "RMS error [%]", "focal_relative", "focal_predicted", 100)):
        for number, (key, name, style) in enumerate(((found, "against the truth", "-"), (stated, "as stated", "--"))):
            line(ax, number, [r["views"] for r in rows], [factor * r[key] for r in rows], name, style)
        dress(ax, title, "board views", label, "xy")
    return {"": figure}, {"": table(
        ["views", "error over the frame [px]", "stated", "focal length [%]", "stated"],
        [[r["views"]] + [f"{r[k]:.2f}" for k in ("error_px", "predicted_px")]
         + [f"{100 * r[k]:.2f}" for k in ("focal_relative", "focal_predicted")] for r in rows])}


def rig(record):
    parts = {name: [r for r in record["rows"] if r["part"] == name] for name in ("views", "exposures")}
    figure, axes = panels(2, 2, 6.2, 4.2)
    for ax, name, key, title, label in ((axes[0], "views", "boards", "calibration views", "board views"),
                                        (axes[1], "exposures", "exposures", "exposures", "exposures of a pattern")):
        for quantity, number in (("μ", 1), ("κ", 0)):
            field = "log_mu" if quantity == "μ" else "log_kappa"
            for end, found, style in (("", "found", "-"), ("_predicted", "predicted", "--")):
                line(ax, number, [r[key] for r in parts[name]], [100 * r[field + end] for r in parts[name]],
                     f"{quantity}, {found}", style)
        dress(ax, title, label, "change of the median voxel [%]", "y")
    changes = lambda r: [fine_percent(r[k]) for k in ("value_relative", "log_kappa", "log_kappa_predicted", "log_mu",
                                                      "log_mu_predicted")] + [f"{r['validation_E']:.1e}"]
    head = ["a measurement", "κ", "predicted", "μ", "predicted", "validation E"]
    return {"": figure}, {
        "-views": table(["boards, planes", "refused", "seen face [camera px]", "lit face [projector px]",
                         "turn [degrees]"] + head,
                        [[f"{r['boards']}, {r['planes']}", r["refused"]]
                         + [f"{r[k]:.2f}" for k in ("camera_px", "projector_px", "turn_degrees")] + changes(r)
                         for r in parts["views"]]),
        "-exposures": table(["exposures", "scale"] + head,
                            [[r["exposures"], fine_percent(r["scale_relative"])] + changes(r)
                             for r in parts["exposures"]])}


def hdr(record):
    rows = record["rows"]
    figure, axes = panels(3, 1, 9, 5)
    for ax, key, title, label in ((axes[0], "relative_rms", "Radiance, four decades",
                                   "relative error (root mean square)"),
                                  (axes[1], "dark_rms", "Radiance, darkest decade",
                                   "relative error (root mean square)"), (axes[2], "seconds", "Merge", "CPU seconds")):
        for number, method in enumerate(unique(rows, "method")):
            some = [r for r in rows if r["method"] == method]
            line(ax, number, [r["exposures"] for r in some], [r[key] for r in some], method)
        dress(ax, title, "exposures from 1/30 s to 8 s", label, "y", "outside")
    at = {(r["method"], r["exposures"]): r for r in rows}
    methods = unique(rows, "method")
    return {"": figure}, {"": table(
        ["exposures"] + methods + [f"{m}, darkest decade" for m in methods] + [f"{m}, CPU" for m in methods],
        [[n] + [percent(at[m, n][key], 1) for key in ("relative_rms", "dark_rms") for m in methods]
         + [f"{1e3 * at[m, n]['seconds']:.0f} ms" for m in methods] for n in unique(rows, "exposures")])}


# ---- Where diffusion holds

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
    include = ("// Written by scripts/bench_charts.py: do not edit. Errors of diffusion against transport, relative;\n"
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


# ---- docs/limits.md

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
# Of maps, in the order of a grid; a name that ends in another's comes first.
MAPPED = ("embedded", "grid", "polygrid", "boundary_integral", "montecarlo", "beam-diffusion", "better-dipole",
          "dipole-rotated", "dipole")


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


def polygrid_convergence(record):
    """Error against nodes processed, as figure 15 of [W], and against processor time."""
    rows = record["rows"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.5), constrained_layout=True, sharey=True)
    lines = []
    for number, scheme in enumerate(unique(rows, "scheme")):
        own = [r for r in rows if r["scheme"] == scheme and r["error"] > 1e-9]
        line(left, number, [r["nodes"] / 1e5 for r in own], [r["error"] for r in own], scheme)
        line(right, number, [r["ms"] for r in own], [r["error"] for r in own], scheme)
        until = [next((r for r in own if r["error"] <= bound), None) for bound in (5e-3, 1e-4, 1e-5)]
        lines.append([scheme] + ["not reached" if r is None else f"{r['nodes']:,}, {r['ms']:.2g} ms" for r in until])
    dress(left, f"cube of {record['cells']:,} cells, one side lit", "nodes processed [100,000]", "Σ(L − L₀)² / Σ L₀²", "xy")
    dress(right, "the same against time", "processor time [ms]", "", "xy")
    return {"": figure}, {"": provenance(record) + "\n" + table(["nodes and processor time until", "5e-3", "1e-4", "1e-5"], lines)}


def polygrid_quality(record):
    """Cells of polygrids, and the six weights of [W] that cannot be used."""
    lines = [[r["object"], r["refused"]] if "refused" in r else
             [r["object"], f"{r['cells']:,}", f"{r['least_jacobian']:.2f}", f"{r['mean_jacobian']:.2f}", r["inverted"],
              f"{r['mean_gap']:.3f}", f"{r['largest_gap']:.2f}", f"{r['aspect']:.2f}", f"{r['volume_spread']:.2f}",
              f"{r['volume_ratio']:.3f}", f"{r['negative_weights'] / r['cells']:.0%}, {r['ill_conditioned'] / r['cells']:.1%}",
              f"{r['cpu_s']:.1f}"] for r in record["rows"]]
    head = ["object", "cells", "least Jacobian", "mean", "inverted", "mean gap", "largest gap", "aspect", "volume spread",
            "volume ratio", "six weights: negative, ill-conditioned", "processor time [s]"]
    return {}, {"": provenance(record) + "\n" + table(head, [row + [""] * (len(head) - len(row)) for row in lines])}


def polygrid_frames(record):
    """Frames a second beside Table III of [W]."""
    def fps(milliseconds):
        return f"{1e3 / milliseconds:.1f}"
    lines = [[r["paper"], f"{r['cells']:,}",
              f"{fps(r['surface_diffusion_elapsed_ms'])}, {fps(r['diffusion_elapsed_ms'])}", f"{r['paper_diffusion_fps']:.0f}",
              f"{fps(r['surface_frame_elapsed_ms'])}, {fps(r['frame_elapsed_ms'])}", f"{r['paper_fps']:.0f} ({r['paper_coherent_fps']:.0f})",
              f"{r['light_ms']:.0f} + {r['diffusion_ms']:.0f} ({r['iterations']}) + {r['exitance_ms']:.0f}",
              f"{percent(r['error'], 2)}, {percent(r['largest_error'], 1)}",
              f"{r['edit_media_ms']:.0f} + {r['edit_light_ms']:.0f} + {r['edit_diffusion_ms']:.0f} ({r['edit_iterations']}), {r['edit_elapsed_ms']:.0f}"]
             for r in record["rows"]]
    return {}, {"": provenance(record) + "\n" + table(
        ["model of [W]", "cells", "diffusions per second: surface light, beams", "[W]", "frames per second: surface light, beams",
         "[W] (coherent)", "moved: light + diffusion (iterations) + exitance [ms of processor]",
         "from converged: 2-norm, largest",
         "edit: equations + light + diffusion (iterations) [ms of processor], elapsed [ms]"], lines)}


def form_factors(record):
    """Error against time; "near": triangles of consequence whose edges the point does not lie on."""
    rows = record["rows"]
    names = [f"{r['method']}, pieces of {r['ratio']:g}" if r["ratio"] else r["method"] for r in rows]
    figure, (ax,) = panels(1)
    for number, (name, r) in enumerate(zip(names, rows)):
        line(ax, number, 2 * [r["microseconds"]], [r["near_median"], r["near_most"]], name)
    dress(ax, f"{record['cases']} random triangles: median and largest error of near ones", "processor time of one [µs]",
          "relative error", "xy")
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["method, pieces over their distance", "near: median error", "near: within 1 %", "near: most", "samples", "processor time of one"],
        [[name, f"{r['near_median']:.1e}", percent(r["near_within_1_percent"], 1), f"{r['near_most']:.1e}",
          f"{r['samples']:.0f}", f"{r['microseconds']:.2g} µs"] for name, r in zip(names, rows)])}


def importance(record):
    """Local diffusion: error at equal samples, a panel a scene."""
    rows = record["rows"]
    figure, axes = panels(len(unique(rows, "scene")))
    for ax, scene in zip(axes, unique(rows, "scene")):
        for number, method in enumerate(unique(rows, "method")):
            own = [r for r in rows if r["scene"] == scene and r["method"] == method]
            line(ax, number, [r["samples"] for r in own], [r["error"] for r in own], method)
        dress(ax, scene, "samples a triangle", "root-mean-square error, relative", "xy")
    lines = []
    for scene in record["scenes"]:
        for method in unique(rows, "method"):
            own = {r["samples"]: r for r in rows if r["scene"] == scene["scene"] and r["method"] == method}
            lines.append([scene["scene"], method] + [percent(own[n]["error"], 1) if n in own else "" for n in (32, 128, 512)]
                         + [f"{own[128]['microseconds']:.0f} µs" if 128 in own else ""])
    missed = ", ".join(f"{s['scene']} {percent(s['missed_in_image_space'], 1)}" for s in record["scenes"])
    return {"": figure}, {"": provenance(record) + "\n" + table(["scene", "samples by", "32", "128", "512", "processor time of 128"], lines)
                          + f"\nWhat entered where the eye does not see, of the exitance seen: {missed}.\n"}


def object_map(name, values):
    """Exitance of a model and its difference from the reference, patch by patch, on the lit side and the far one."""
    # Of triangles: corners; exitance, its mean over the patch, the reference's.
    corners, exitance, mean, reference = values[:, :9].reshape(-1, 3, 3), values[:, 9], values[:, 10], values[:, 11]
    figure, axes = plt.subplots(2, 3, figsize=(9.0, 8.0), constrained_layout=True)
    top = float(reference.max())
    difference = 100.0 * (mean - reference) / reference.clip(1e-3 * top)
    for row, sign, side in ((axes[0], 1.0, "lit side"), (axes[1], -1.0, "far side")):
        for ax, shown, title, colours, norm in (
                (row[0], exitance, "exitance", "viridis", matplotlib.colors.LogNorm(0.02 * top, top)),
                (row[1], reference, "Monte Carlo, patches", "viridis", matplotlib.colors.LogNorm(0.02 * top, top)),
                (row[2], difference, "difference of patches [%]", "RdBu_r", matplotlib.colors.Normalize(-20.0, 20.0))):
            figure.colorbar(draw_surface(ax, f"{title}, {side}", corners, shown, sign, colours, norm), ax=ax, shrink=0.8)
    figure.suptitle(name)
    return figure


def draw_surface(ax, title, corners, shown, sign, colours, norm):
    """Triangles in their colours, seen from the light (sign 1) or from opposite it."""
    ahead, right, up = frame_of([sign * x for x in (3.0, 5.0, 8.0)])  # towards the light
    seen = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ ahead > 0.0
    order = numpy.flatnonzero(seen)[numpy.argsort(corners[seen].mean(axis=1) @ ahead)]
    outlines = numpy.stack([corners[order] @ right, corners[order] @ up], axis=-1)
    patches = PolyCollection(outlines, array=shown[order].clip(norm.vmin, norm.vmax), cmap=colours, norm=norm,
                             edgecolors="face", linewidths=0.2)
    ax.add_collection(patches)
    ax.set(title=title, aspect="equal", xticks=[], yticks=[])
    ax.autoscale_view()
    ax.grid(False)
    return patches


def map_grid(maps, titles, models):
    """A row for each scene, by title: exitance by model on the side away from the light, beside Monte Carlo's."""
    models = [model for model in models if any(f"{name}-{model}" in maps for name in titles.values())]
    figure, axes = plt.subplots(len(titles), 1 + len(models), squeeze=False, constrained_layout=True,
                                figsize=(10.0, (8.5 if len(models) > 4 else 9.2) * len(titles) / (1 + len(models))))
    for row, (title, name) in zip(axes, titles.items()):
        values = next(maps[f"{name}-{model}"] for model in models if f"{name}-{model}" in maps)
        top = float(values[:, 11].max())
        norm = matplotlib.colors.LogNorm(0.01 * top, top)
        for ax, model in zip(row, ["Monte Carlo, patches", *models]):
            if f"{name}-{model}" in maps or ax is row[0]:
                shown = maps.get(f"{name}-{model}", values)
                draw_surface(ax, model, shown[:, :9].reshape(-1, 3, 3), shown[:, 11 if ax is row[0] else 9], -1.0, "viridis", norm)
                ax.title.set_fontsize("x-small" if len(models) > 4 else "medium")
            else:
                ax.set_visible(False)
        row[0].set_ylabel(title, fontsize="x-small" if len(models) > 4 else "medium")
    return figure


def map_pictures(maps):
    """Figures by name: of a scene that one model has a map of its own, the others in grids."""
    models_of = {}
    for name in maps:
        model = next(model for model in MAPPED if name.endswith("-" + model))
        models_of.setdefault(name[:-len(model) - 1], []).append(model)
    for scene, models in models_of.items():
        if len(models) == 1:
            yield f"map-{scene}-{models[0]}", object_map(f"{scene}-{models[0]}", maps[f"{scene}-{models[0]}"])
    several = [scene for scene, models in models_of.items() if len(models) > 1]
    grids = {"thesis": {title: scene for title, scene in THESIS.items() if scene in several},
             "grid": {scene: scene for scene in several if scene not in THESIS.values()}}
    for grid, titles in grids.items():
        if titles:
            yield grid, map_grid(maps, titles, THESIS_MODELS if grid == "thesis" else MAPPED)


def frame_of(toward):
    """Three axes: towards the eye, right, up, y being up."""
    ahead = numpy.array(toward) / numpy.linalg.norm(toward)
    right = numpy.cross([0.0, 1.0, 0.0], ahead)
    right /= numpy.linalg.norm(right)
    return ahead, right, numpy.cross(ahead, right)


def iterations_or_failure(row):
    return f"{'' if row['ended'] == 'converged' else 'not in '}{row['iterations']}"


def sentences(rows):
    """What the program reports of each case; a note that many make once only, known by its beginning."""
    text, shown = "\nWhat the program reports:\n\n", set()
    for row in rows:
        said = "".join(f' "{s}"' for s in row["warnings"]) or " no warning"
        for note in row["remarks"]:
            if note[:12] not in shown:
                said += f', note "{note}"'
                shown.add(note[:12])
        text += f"- {row['case']}:{said}\n"
    return text


def medium_and_contrast(row):
    """κ and contrast"""
    return f"{row['κ']}, {short(row['contrast'])}"


def block_and_method(row):
    """block and method"""
    return f"{row['block']}, {row['method']}"


LIMITS = {
    "contrast": lambda rows: cross(rows, "κ", "contrast",
                                   lambda r: f"{iterations_or_failure(r)} ({short(r['true error'])})"),
    "size": lambda rows: cross(rows, medium_and_contrast, "grid", iterations_or_failure),
    "floor": lambda rows: cross(rows, "κ", "contrast", lambda r: f"{short(r['true error, single'])} / "
                                                                 f"{short(r['true error, double'])}"),
    "absorption": lambda rows: flat(rows, ["μ [1/mm]", "voxels per penetration depth", "iterations", "true error",
                                           "transmitted", "its error, 1e-6 single", "its error, 1e-12 double",
                                           "grid's error of it", "program"]),
    "coarse": lambda rows: flat(rows, list(rows[0])),
    "stencil": lambda rows: cross(rows, "κ", "contrast", lambda r: f"{100 * r['accounted for by (8)']:.4g} % "
                                                                   f"({short(r['distance of the maps'])})"),
    "relaxation": lambda rows: cross(rows, block_and_method, "sweeps",
                                     lambda r: f"{short(r['residual'])} → {short(r['error of the maps'])}"),
    "inverse": lambda rows: flat(rows, ["case", "model", "ended", "χ² per value", "E, light not fitted", "κ error",
                                        "μ error"], {"κ error": percent, "μ error": percent}) + sentences(rows),
    "consistency": lambda rows: cross(rows, "data", "block",
                                      lambda r: f"{short(r['factor found'])} ({short(r['its spread'])}), "
                                                f"{short(r['shift found'])}; " + ", ".join(
                                                    percent(r[f"reported: {what}"])
                                                    for what in ("scale", "shift", "eta"))),
    "objects": lambda rows: cross(rows, "object", "equivalent", lambda r: f"{iterations_or_failure(r)} "
                                                                          f"({short(r['smallest volume fraction'])})"),
}

SUBJECTS = {"forward-headline": headline, "forward-kernels": kernels, "forward-peers": peers,
            "forward-grids": time_error, "forward-scaling": scaling,
            "validity": validity, "slabs": slabs, "inverse-optimisers": optimisers,
            "inverse-scores": scores, "inverse-embedded": scores, "inverse-patterns": patterns,
            "inverse-voxels": voxels, "inverse-montecarlo": monte_carlo, "inverse-samples": samples,
            "inverse-validation": ablations, "inverse-regularisers": ablations, "inverse-losses": ablations, "inverse-population": ablations,
            "uncertainty": uncertainty, "calibration": calibration, "rig": rig, "hdr": hdr,
            "polygrid-convergence": polygrid_convergence, "polygrid-frames": polygrid_frames,
            "polygrid-polygrid": polygrid_quality, "objects-refinement": refinement,
            "objects-estimate": estimates, "objects-picture": pictures,
            "objects-models": objects, "objects-cost": object_costs, "objects-auto": automatic,
            **{name: (lambda record: ({}, {"": flat(record["rows"], list(record["rows"][0]))}))
               for name in ("dipole-hierarchy", "dipole-profiles", "dipole-energy")},
             "dipole-importance": importance, "dipole-form-factors": form_factors,
            **{f"limits-{name}": (lambda record, made=made: ({}, {"": made(record["rows"])}))
               for name, made in LIMITS.items()}}


# ---- Files

def write(file, text):
    temporary = file.with_name(file.name + ".tmp")
    temporary.write_text(text)
    os.replace(temporary, file)


def draw(folder):
    """Pictures and texts of every record in the folder, by name."""
    pictures, texts = {}, {}
    for stem, make in SUBJECTS.items():
        file = folder / f"{stem}.json"
        if not file.exists():
            continue
        record = json.loads(file.read_text())
        if record.get("format") != "kappamu-bench-" + stem.split("-")[0] or record.get("version") != 2:
            raise SystemExit(f"bench_charts: {file} is no record of this version; remove it and measure again")
        try:
            figures, made = make(record)
        except KeyError as missing:
            raise SystemExit(f"bench_charts: {file} has no {missing}: another version measured it; measure again") from None
        for end, figure in figures.items():
            pictures[stem + end] = folder / f"{stem}{end}.png"
            figure.savefig(pictures[stem + end], dpi=100, bbox_inches="tight", metadata={"Software": None})
            plt.close(figure)
        for end, text in made.items():
            write(folder / (stem + end + ("" if "." in end else ".md")), text)
            texts[stem + end] = text
    maps = {file.stem.removeprefix("objects-map-"): numpy.load(file) for file in sorted(folder.glob("objects-map-*.npy"))}
    for name, figure in map_pictures(maps):
        stem = f"objects-{name}"
        pictures[stem] = folder / f"{stem}.png"
        figure.savefig(pictures[stem], dpi=100, metadata={"Software": None})
        plt.close(figure)
    return pictures, texts


def renewed(page, texts):
    """The page with the text of every record that it has a place for."""
    def place(match):
        text = texts.get(match.group(1))
        return match.group(0) if text is None else f"<!-- bench:{match.group(1)} -->\n\n{text.strip()}\n\n<!-- /bench -->"
    return re.sub(r"<!-- bench:([a-z-]+) -->\n.*?<!-- /bench -->", place, page, flags=re.S)


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        raise SystemExit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    pictures, texts = draw(folder)
    if not pictures and not texts:
        raise SystemExit(f"bench_charts: {folder} holds no record; measure with `kappamu bench SUBJECT -o {folder}`")
    for page in map(pathlib.Path, sys.argv[2:]):
        text = page.read_text()
        write(page, renewed(text, texts))
        for name, picture in pictures.items():
            if f"images/{name}.png" in text:
                (page.parent / "images" / f"{name}.png").write_bytes(picture.read_bytes())
    print(f"{len(pictures)} pictures and {len(texts)} tables of {folder}")


if __name__ == "__main__":
    main()

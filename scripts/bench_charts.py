#!/usr/bin/python3
"""Charts and tables of the records that `kappamu bench` wrote.

    scripts/bench_charts.py FOLDER              draws FOLDER/<record>.png and writes FOLDER/<record>.md
    scripts/bench_charts.py FOLDER PAGE.md...   also renews the pages: the text between `<!-- bench:<record> -->`
                                                and `<!-- /bench -->`, and the pictures in images/ beside them

A record that was not measured leaves its place as it is. Needs Debian's python3-matplotlib.
"""
import json
import os
import pathlib
import re
import statistics
import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy
from matplotlib.collections import PolyCollection

from charts.common import (MARKS, PlainNumbers, cross, dress, fine_percent, flat, line, panels, percent, provenance,
                           short, table, unique)
from charts.diffusion import slabs, validity
from charts.forward import headline, kernels, peers, scaling, time_error
from charts.inverse import ablations, optimisers, patterns, samples, scores, uncertainty, voxels
from charts.rig import calibration, hdr, rig


# ---- kappamu bench objects

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
        for note in row["notes"]:
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
            "inverse-voxels": voxels, "inverse-samples": samples,
            "inverse-validation": ablations, "inverse-regularisers": ablations, "inverse-losses": ablations, "inverse-population": ablations,
            "uncertainty": uncertainty, "calibration": calibration, "rig": rig, "hdr": hdr,
            "polygrid-convergence": polygrid_convergence, "polygrid-frames": polygrid_frames,
            "polygrid-polygrid": polygrid_quality, "objects-refinement": refinement,
            "objects-estimate": estimates, "objects-picture": pictures, "objects-invariance": invariances,
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

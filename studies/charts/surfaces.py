"""`kappamu-studies polygrid` and `dipole`."""
import matplotlib.pyplot as plt

from charts.common import dress, line, panels, percent, provenance, table, unique


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
              f"{r['edit_volume_ms']:.0f} + {r['edit_media_ms']:.0f} + {r['edit_light_ms']:.0f} + {r['edit_diffusion_ms']:.0f} ({r['edit_iterations']}) + "
              f"{r['edit_exitance_ms'] + r['edit_picture_ms']:.0f}, {r['edit_elapsed_ms']:.0f}"]
             for r in record["rows"]]
    return {}, {"": provenance(record) + "\n" + table(
        ["model of [W]", "cells", "diffusions per second: surface light, beams", "[W]", "frames per second: surface light, beams",
         "[W] (coherent)", "moved: light + diffusion (iterations) + exitance [ms of processor]",
         "from converged: 2-norm, largest",
         "stroke: volume + equations + light + diffusion (iterations) + picture [ms of processor], elapsed [ms]"], lines)}


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

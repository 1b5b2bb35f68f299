"""`kappamu-studies forward`."""
import math

from charts.common import GREY, dress, line, panels, percent, provenance, table, unique


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
        texts[""] += (f"- {name}, {peer['ranks']} ranks, settings tried on one pattern at residual 1e-6.\n"
                      + "".join(f"  - `{tried}`\n" for tried in peer["tried"]))
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
    samples = [(math.prod(run["problem"]["grid"]), grid_name(run["problem"]["grid"]), s, run["problem"]["patterns"])
               for run in record["runs"] for s in run["samples"]]
    kind = lambda s: (s[2]["method"], s[3])
    for number, method in enumerate(unique(samples, kind)):
        some = [s for s in samples if kind(s) == method]
        cells, seconds = [s[0] for s in some], [s[2]["seconds_per_rhs"] for s in some]
        label = f"{solver_label(some[0][2])}, {some[0][3]} pattern{'s' if some[0][3] > 1 else ''}"
        if number == 0:
            time.plot(cells, [seconds[-1] * n / cells[-1] for n in cells], "--", color=GREY,
                      label="proportional to unknowns")
        line(time, number, cells, seconds, label)
        line(count, number, cells, [s[2]["iterations"] for s in some], label)
        rows += [[grid, label, s["iterations"], f"{s['seconds_per_rhs']:.5f}",
                  f"{1e9 * s['seconds_per_rhs'] / n:.1f}",
                  "–" if s["true_error"] is None else f"{s['true_error']:.1e}"] for n, grid, s, _ in some]
    dress(time, "Cost against unknowns, cubes with inclusions, residual 1e-6",
          "unknowns per right-hand side", "seconds per right-hand side", "xy")
    dress(count, "Iterations against unknowns", "unknowns per right-hand side",
          "iterations of the slowest pattern", "x")
    count.set_ylim(0)
    return {"": figure}, {"": provenance(record) + "\n" + table(
        ["grid", "method", "iterations", "per right-hand side [s]", "per unknown [ns]", "true error"], rows)}

"""`kappamu-studies devices`: every device beside the processor."""
import json
import pathlib

from charts.common import provenance, short, table, unique

KINDS = {"host": "host, without OpenCL", "CPU": "processor by OpenCL", "GPU": "GPU", "other": "other device"}


def time(seconds):
    if seconds is None:
        return ""
    if seconds < 0.1:
        return f"{1e3 * seconds:.3g} ms"
    return f"{seconds:.3g} s" if seconds < 100 else f"{seconds:.0f} s"


def rate(row):
    value = row["rate"]
    return f"{value / 1e6:.3g} million" if value >= 1e5 else f"{value:.3g}"


def marble(folder):
    """Grid and seconds of all three channels' fit, where section `samples` of subject `inverse` measured it beside, and
    whether at its full size."""
    file = pathlib.Path(folder) / "inverse-samples.json"
    record = json.loads(file.read_text()) if file.exists() else {"rows": []}
    return [(" × ".join(map(str, r["grid"])), r["seconds"], record["size"] == "full")
            for r in record["rows"] if r["sample"] == "marble"]


def devices(record):
    rows = record["rows"]
    kinds = [kind for kind in KINDS if any(r["kind"] == kind for r in rows)]
    first = lambda some: next(iter(some), None)
    lines = []
    for task in unique(rows, "task"):
        of = {kind: first(r for r in rows if (r["task"], r["kind"]) == (task, kind)) for kind in kinds}
        known = [r for r in of.values() if r and "seconds" in r]
        gpu = of.get("GPU")
        ratio = gpu.get("times_processor") if gpu else None
        met = {True: "met", False: "missed", None: "not measured"}[gpu.get("goal_met") if gpu else None]
        goal = first(r["goal"] for r in known) or ""
        lines.append([task, first(r["size"] for r in known) or ""]
                     + [("–" if of[k] is None else time(of[k].get("seconds")) or "refused") for k in kinds]
                     + ["–" if ratio is None else f"{ratio:.3g}", goal, met if goal else ""])
    place = "GPU" if "GPU" in kinds else "CPU"  # that `auto` takes
    for grid, seconds, full in marble(record["folder"]):
        met = "not measured" if place != "GPU" or not full else "met" if seconds <= 5 else "missed"
        lines.append(["fit of marble, RGB", grid, *(time(seconds) if k == place else "" for k in kinds), "–", "≤ 5 s", met])
    head = ["task", "size", *(KINDS[k] for k in kinds), "GPU : fastest processor", "goal of a GPU", ""]
    every = [[r["task"], r["device"], time(r.get("seconds")), time(r.get("set_up_seconds")),
              f"{rate(r)} {r['unit']}" if "rate" in r else "",
              "–" if r.get("difference") is None else f"{short(r['difference'])} ({short(r['allowed'])})",
              "–" if r.get("times_processor") is None else f"{r['times_processor']:.3g}",
              r.get("refused") or r.get("note", "")] for r in rows]
    return {}, {"": provenance({**record, "rows": []}) + "\n" + table(head, lines) + "\n" + table(
        ["task", "device", "time", "set-up", "a second", "difference (allowed)", "over the fastest processor", ""], every)}

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
    """The fit of all three channels that section `samples` of subject `inverse` measured beside, as rows are."""
    file = pathlib.Path(folder) / "inverse-samples.json"
    rows = json.loads(file.read_text())["rows"] if file.exists() else []
    return [{"task": "fit of marble, RGB", "kind": "", "device": r["device"], "seconds": r["seconds"],
             "size": " × ".join(map(str, r["grid"])), "goal": "≤ 5 s", "meets": r["seconds"] <= 5}
            for r in rows if r["sample"] == "marble"]


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
    for r in marble(record["folder"]):
        lines.append([r["task"], r["size"], *("" for _ in kinds), f"{time(r['seconds'])} ({r['device']})", r["goal"],
                      "met" if r["meets"] else "missed"])
    head = ["task", "size", *(KINDS[k] for k in kinds), "GPU : fastest processor", "goal of a GPU", ""]
    every = [[r["task"], r["device"], time(r.get("seconds")), time(r.get("set_up_seconds")),
              f"{rate(r)} {r['unit']}" if "rate" in r else "",
              "–" if r.get("difference") is None else f"{short(r['difference'])} ({short(r['allowed'])})",
              "–" if r.get("times_processor") is None else f"{r['times_processor']:.3g}",
              r.get("refused") or r.get("note", "")] for r in rows]
    return {}, {"": provenance({**record, "rows": []}) + "\n" + table(head, lines) + "\n" + table(
        ["task", "device", "time", "set-up", "a second", "difference (allowed)", "over the fastest processor", ""], every)}

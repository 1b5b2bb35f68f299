#!/usr/bin/env python3
"""Prints the demo's table and, as the last line, one JSON object made of what simulate, run and score said.

usage: demo_summary.py FOLDER   (holding simulate.json, run.json and score.json)
"""
import json
import pathlib
import sys


def load(folder, name):
    return json.loads((folder / name).read_text())


def coverage(channels):
    return {name: round(found["within_2_std"], 3) for name, found in channels.items()}


def percent(channels):
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in channels.items()) or "not stated"


def main():
    folder = pathlib.Path(sys.argv[1])
    simulated, run, score = (load(folder, name) for name in ("simulate.json", "run.json", "score.json"))
    seconds = {"simulate": simulated["seconds"], **run["seconds"], "score": score["seconds"]}
    result = {
        "sample": run["sample"],
        "grid": run["grid"],
        "camera_rms_px": run["camera_rms_px"],
        "projector_rms_px": run["projector_rms_px"],
        "hdr_relative_error_median": score["hdr_relative_error_median"],
        "truth_E": score["truth_E"],
        "validation_E": run["validation_E"],
        "status": run["status"],
        "verdict": run["verdict"],
        "kappa_within_2_std": coverage(score["kappa_coverage"]),
        "mu_within_2_std": coverage(score["mu_coverage"]),
        "kappa_mu_volume": run["kappa_mu_volume"],
        "report": run["report"],
        "device": run.get("device"),
        "warnings": run.get("warnings", []),
        "seconds": {stage: round(value, 2) for stage, value in seconds.items()},
        "seconds_total": round(sum(seconds.values()), 2),
    }
    rows = [
        ("camera reprojection RMS", f"{result['camera_rms_px']:.3f} px"),
        ("projector reprojection RMS", f"{result['projector_rms_px']:.3f} px"),
        ("HDR relative error (median)", f"{100 * result['hdr_relative_error_median']:.2f} %"),
        ("truth error E, unseen patterns", f"{result['truth_E']:.2e}"),
        ("κ within 2 stated deviations", percent(result["kappa_within_2_std"])),
        ("μ within 2 stated deviations", percent(result["mu_within_2_std"])),
        *((f"time: {stage}", f"{value:.1f} s") for stage, value in seconds.items()),
        ("time: total", f"{result['seconds_total']:.1f} s"),
        ("report", result["report"]),
        ("verdict", result["verdict"]["sentence"]),
    ]
    print()
    for name, value in rows:
        print(f"  {name:<36} {value}")
    print()
    print(json.dumps(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())

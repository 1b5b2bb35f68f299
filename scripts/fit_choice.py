#!/usr/bin/env python3
"""Makes the table that `model: auto` chooses by, from what `kappamu bench objects` measured on its tuning scenes.

    kappamu bench objects --section models -o out/choice                      # errors, numerics at 1 %
    kappamu bench objects --section models -o out/choice-03 --tolerance 0.03  # costs at other tolerances
    kappamu doctor --measure --json > out/probe.json                          # the probe on this machine
    scripts/fit_choice.py --probe out/probe.json out/choice*/objects-models.json

Least squares of the logarithms (forward/choice/model_table.h has the laws); errors only from rows asked for 1 % or less,
those of montecarlo from the references' own standard errors, which grow with the square root of the triangles. Writes forward/choice/measured_models.inc and prints how well
the laws fit. A model is a row of the table once records have it.
"""
import argparse
import json
import pathlib
import sys

import numpy

FOLDER = pathlib.Path(__file__).resolve().parent.parent
SMOOTH = 0.003  # model_table.cpp
FIELDS = ["constant", "thickness", "absorption", "edges", "contrast", "triangles", "tolerance"]
# Of the fields, those that a law has; contrast only where a model takes media that vary.
ERROR = ["thickness", "absorption", "edges", "contrast"]
SECONDS = ["thickness", "absorption", "contrast", "triangles", "tolerance"]
PER_PHOTON = ["thickness", "absorption", "contrast"]
NOISE = ["thickness", "absorption", "edges", "contrast"]
FOLLOW_REENTRY = {"embedded", "montecarlo"}
BOXES = ("cube-", "slab-", "brick-", "plate-")
RIDGE = 1e-3  # of the rows, on slopes: keeps those that the scenes do not determine near zero


def feature(row, field):
    return {"thickness": lambda: row["thickness_over_mean_free_path"], "absorption": lambda: 1.0 - row["albedo"],
            "edges": lambda: row["edges"] + SMOOTH, "contrast": lambda: row["contrast"],
            "triangles": lambda: row["triangles"], "tolerance": lambda: row["tolerance"]}[field]()


def fit(rows, values, fields):
    """Slopes by field with the constant, and the spread of the residuals."""
    logs = numpy.log([[feature(row, field) for field in fields] for row in rows])
    target = numpy.log(values)
    centre = logs.mean(axis=0)
    lean = logs - centre
    used = lean.std(axis=0) > 1e-6
    lean = lean[:, used]
    weight = lean.T @ lean + RIDGE * len(rows) * numpy.eye(lean.shape[1])
    slopes = numpy.zeros(len(fields))
    slopes[used] = numpy.linalg.solve(weight, lean.T @ (target - target.mean()))
    residual = target - target.mean() - lean @ slopes[used]
    law = dict.fromkeys(FIELDS, 0.0) | dict(zip(fields, slopes))
    law["constant"] = float(target.mean() - centre @ slopes)
    law["spread"] = float(numpy.sqrt((residual ** 2).sum() / max(1, len(rows) - used.sum() - 1)))
    return law


def laws_of(name, rows):
    """Error and seconds of one model."""
    if name == "montecarlo":
        error = fit(rows, [r["reference_error"] * (r["reference_photons"] / r["patches"]) ** 0.5 for r in rows], NOISE)
        error["triangles"] = 0.5
        return error, fit(rows, [r["cpu_seconds"] / r["photons"] for r in rows], PER_PHOTON)
    exact = [r for r in rows if r["tolerance"] <= 0.01]
    # Below a third of the reference's own noise an error is not resolved.
    error = fit(exact, [max(r["error"], 0.3 * r["reference_error"]) for r in exact], ERROR)
    return error, fit(rows, [r["cpu_seconds"] for r in rows], SECONDS)


def text_of(law):
    return "{" + ", ".join(f"{law[field]:.5g}" for field in FIELDS + ["spread"]) + "}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="+", type=pathlib.Path)
    parser.add_argument("--probe", type=pathlib.Path, help="what `kappamu doctor --measure --json` printed; else the table's own")
    parser.add_argument("--table", type=pathlib.Path, default=FOLDER / "forward/choice/measured_models.inc")
    arguments = parser.parse_args()
    rows = [row for file in arguments.records for row in json.loads(file.read_text())["rows"]]
    answered = [row for row in rows if "refused" not in row]
    probe = json.loads(arguments.probe.read_text())["model_costs"]["seconds"] if arguments.probe else {}
    lines = []
    for name in dict.fromkeys(row["model"] for row in answered):
        own = [row for row in answered if row["model"] == name]
        error, seconds = laws_of(name, own)
        traits = [any(r["contrast"] > 1.0 for r in own), not all(r["name"].startswith(BOXES) for r in own),
                  name in FOLLOW_REENTRY]
        lines.append(f'    {{"{name}", {", ".join(str(trait).lower() for trait in traits)},\n     {text_of(error)},\n'
                     f"     {text_of(seconds)},\n     {probe.get(name, 0.0):.4g}}},\n")
        print(f"{name}: {len(own)} rows, error within a factor of {numpy.exp(error['spread']):.2f}, "
              f"seconds within {numpy.exp(seconds['spread']):.2f} (one standard deviation)")
    thickness = [r["thickness_over_mean_free_path"] for r in answered]
    albedo = [r["albedo"] for r in answered]
    arguments.table.write_text(
        "// Written by scripts/fit_choice.py: do not edit. Errors, seconds and the probe's seconds of model_table.h.\n"
        f"constexpr MeasuredRange range{{{min(thickness):.4g}, {max(thickness):.4g}, {min(albedo):.4g}, {max(albedo):.5g},\n"
        f"                               {max(r['contrast'] for r in answered):.4g}}};\n"
        f"constexpr std::array<MeasuredModel, {len(lines)}> models{{{{\n{''.join(lines)}}}}};\n")
    print(arguments.table)


if __name__ == "__main__":
    sys.exit(main())

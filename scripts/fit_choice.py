#!/usr/bin/python3
"""Makes the table that `model: auto` chooses by, from what `kappamu bench objects` measured on its tuning scenes.

    kappamu bench objects --section models -o out/choice                      # errors, numerics at 1 %
    kappamu bench objects --section models -o out/choice-03 --tolerance 0.03  # costs at other tolerances
    kappamu doctor --measure --json > out/probe.json                          # the probe on this machine
    scripts/fit_choice.py --probe out/probe.json out/choice*/objects-models.json

Errors: sums of terms with coefficients that are not negative, least squares of the relative residuals, from rows asked for
1 % or less; those of montecarlo from the references' own standard errors. Seconds: least squares of logarithms. The laws are
those of forward/choice/model_table.h. Writes forward/choice/measured_models.inc and prints how well the laws fit. A model is
a row of the table once records have it.
"""
import argparse
import json
import pathlib
import sys

import numpy

FOLDER = pathlib.Path(__file__).resolve().parent.parent
TERMS = {"constant": lambda r: 1.0,
         "inverse_thickness": lambda r: 1.0 / r["thickness_over_mean_free_path"],
         "inverse_root_thickness": lambda r: r["thickness_over_mean_free_path"] ** -0.5,
         "absorbed": lambda r: 1.0 - r["albedo"],
         "root_absorbed": lambda r: (1.0 - r["albedo"]) ** 0.5,
         "edges": lambda r: min(r["edges"], 3.0 / r["size_over_mean_free_path"]),
         "inverse_size": lambda r: 1.0 / r["size_over_mean_free_path"]}
LOGARITHMS = {"size": lambda r: r["size_over_mean_free_path"], "absorbed": lambda r: 1.0 - r["albedo"],
              "contrast": lambda r: r["contrast"], "triangles": lambda r: r["triangles"], "tolerance": lambda r: r["tolerance"]}
PER_PHOTON = ["size", "absorbed", "contrast"]
ANY_MEDIUM = {"embedded", "grid", "montecarlo"}
FOLLOW_REENTRY = {"embedded", "montecarlo"}
BOXES = ("cube-", "slab-", "brick-", "plate-", "thin-slab-")
# Models too slow for many scenes: the error of the same physics is measured with another, and the seconds grow with this
# power of the triangles.
SAME_PHYSICS = {"grid": "embedded", "boundary_integral": "embedded", "dipole": "dipole-rotated"}
GROWTH = {"dipole": 2.0, "boundary_integral": 1.0}
RIDGE = 1e-3  # of the rows, on slopes: keeps those that the scenes do not determine near zero


def not_negative(terms, values):
    """Least squares without negative coefficients: the most negative one is left out until none is."""
    kept = list(range(terms.shape[1]))
    while True:
        found = numpy.linalg.lstsq(terms[:, kept], values, rcond=None)[0]
        if len(kept) == 1 or (found >= 0.0).all():
            break
        kept.pop(int(found.argmin()))
    coefficients = numpy.zeros(terms.shape[1])
    coefficients[kept] = found
    return coefficients


def error_law(rows, errors):
    """Coefficients by term, and the spread of log(measured / law)."""
    terms = numpy.array([[term(row) for term in TERMS.values()] for row in rows])
    weights = 1.0 / errors
    for _ in range(30):  # weights from the law and the value together: neither large nor small residuals rule
        coefficients = not_negative(terms * weights[:, None], errors * weights)
        weights = (numpy.maximum(terms @ coefficients, 1e-4) * errors) ** -0.5
    residual = numpy.log(errors / (terms @ coefficients))
    return dict(zip(TERMS, coefficients)) | {"spread": float(numpy.sqrt((residual ** 2).mean()))}


def cost_law(rows, seconds, fields):
    """Constant and slopes of the logarithms, and the residuals' spread."""
    logs = numpy.log([[LOGARITHMS[field](row) for field in fields] for row in rows])
    target = numpy.log(seconds)
    centre = logs.mean(axis=0)
    lean = logs - centre
    slopes = numpy.linalg.solve(lean.T @ lean + RIDGE * len(rows) * numpy.eye(len(fields)), lean.T @ (target - target.mean()))
    law = dict.fromkeys(["constant", *LOGARITHMS], 0.0) | dict(zip(fields, slopes))
    law["constant"] = float(target.mean() - centre @ slopes)
    return law, float((target - target.mean() - lean @ slopes).std())


def grown_law(rows, seconds, power):
    """Constant and spread of a cost that grows with a power of the triangles."""
    logs = numpy.log(seconds) - power * numpy.log([row["triangles"] for row in rows])
    return dict.fromkeys(["constant", *LOGARITHMS], 0.0) | {"constant": float(logs.mean()), "triangles": power}, float(logs.std())


def laws_of(name, answered):
    """Error, seconds and the spread of the seconds of one model."""
    rows = [r for r in answered if r["model"] == name]
    if name == "montecarlo":
        noise = numpy.array([r["reference_error"] * (r["reference_photons"] / r["patches"]) ** 0.5 for r in rows])
        return error_law(rows, noise), *cost_law(rows, [r["cpu_seconds"] / r["photons"] for r in rows], PER_PHOTON)
    exact = [r for r in answered if r["model"] in (name, SAME_PHYSICS.get(name)) and r["tolerance"] <= 0.01]
    # Below a third of the reference's own noise an error is not resolved.
    errors = numpy.array([max(r["error"], 0.3 * r["reference_error"]) for r in exact])
    seconds = [r["cpu_seconds"] for r in rows]
    return error_law(exact, errors), *(grown_law(rows, seconds, GROWTH[name]) if name in GROWTH else
                                       cost_law(rows, seconds, list(LOGARITHMS)))


def text_of(law):
    return "{" + ", ".join(f"{value:.5g}" for value in law.values()) + "}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="+", type=pathlib.Path)
    parser.add_argument("--probe", type=pathlib.Path, help="what `kappamu doctor --measure --json` printed on the machine of the records")
    parser.add_argument("--table", type=pathlib.Path, default=FOLDER / "forward/choice/measured_models.inc")
    arguments = parser.parse_args()
    rows = [row for file in arguments.records for row in json.loads(file.read_text())["rows"]]
    answered = [row for row in rows if "refused" not in row]
    probe = {}
    if arguments.probe:
        measured = json.loads(arguments.probe.read_text())["model_costs"]["models"]
        probe = {row["model"]: row["processor_seconds"] for row in measured}
    lines = []
    for name in dict.fromkeys(row["model"] for row in answered):
        own = [row for row in answered if row["model"] == name]
        error, seconds, spread = laws_of(name, answered)
        traits = [name in ANY_MEDIUM, not all(r["name"].startswith(BOXES) for r in own),
                  name in FOLLOW_REENTRY]
        lines.append(f'    {{"{name}", {", ".join(str(trait).lower() for trait in traits)},\n     {text_of(error)},\n'
                     f"     {text_of(seconds)},\n     {probe.get(name, 0.0):.4g}}},\n")
        print(f"{name}: {len(own)} rows, error within a factor of {numpy.exp(error['spread']):.2f}, "
              f"seconds within {numpy.exp(spread):.2f} (one standard deviation)")
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

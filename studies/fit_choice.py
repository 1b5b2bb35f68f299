#!/usr/bin/python3
"""Makes the table that `model: auto` chooses by, from what `kappamu-studies objects` measured on its tuning scenes.

    studies/fit_choice.py --probe out/probe.json out/*/objects-models.json      # commands: docs/objects-bench.md, "Which model"

Errors: sums of terms with coefficients that are not negative, times powers of e for the light, from rows asked for 1 % or
less, a scene's first row; those of montecarlo from the references' own standard errors. Seconds: least squares of logarithms, from the other rows. The laws are
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
         "absorbed": lambda r: (1.0 - r["albedo"]) * r["thickness_over_mean_free_path"] / (r["thickness_over_mean_free_path"] + DEEP),
         "root_absorbed": lambda r: (1.0 - r["albedo"]) ** 0.5,
         "edges": lambda r: min(r["edges"], 3.0 / r["size_over_mean_free_path"]),
         "inverse_size": lambda r: 1.0 / r["size_over_mean_free_path"]}
DEEP = 3.0  # mean free paths: in thinner objects light is absorbed less often than it leaves
SLANT_OF_SPHERE = 1.0 / 3.0
SHAPES = ("sphere", "slab", "cube", "cylinder", "torus", "box-with-void", "split-cube", "spot", "bob", "nefertiti", "thin-slab",
          "ellipsoid", "brick", "drum", "cone", "plate", "ring", "hollow")
# Slopes of the error's logarithm; under diffuse light what absorption adds has a slope of its own and grows with its power 3/2.
LIGHTS = {"diffuse": lambda r: r["diffuse"], "slant": lambda r: (1.0 - r["diffuse"]) * (r["slant"] - SLANT_OF_SPHERE)}
EXACT = 0.01  # of tolerances: rows asked for no more give the errors, the others the seconds, as models are asked for half a scene's tolerance
LEAST_ABSORBED = 3e-4  # of 1 - albedo: less is nothing
LOGARITHMS = {"thickness": lambda r: r["thickness_over_mean_free_path"], "absorbed": lambda r: max(1.0 - r["albedo"], LEAST_ABSORBED),
              "contrast": lambda r: r["contrast"], "triangles": lambda r: r["triangles"], "tolerance": lambda r: r["tolerance"]}
PER_PHOTON = ["thickness", "absorbed", "contrast"]
# Under a sky rough and thin shapes err twice what the law makes of the few scenes that have one.
MARGIN_UNDER_SKY = {"embedded": 2.0, "grid": 2.0}
BOXES = ("cube-", "slab-", "brick-", "plate-", "thin-slab-")
# Models of few scenes: the error of the same physics is measured with another.
SAME_PHYSICS = {"grid": "embedded"}
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


def factors(rows, slopes):
    """Of every term of every row, by the light."""
    diffuse, slant = ([light(row) for row in rows] for light in LIGHTS.values())
    usual = numpy.exp(slopes[0] * numpy.array(diffuse) + slopes[1] * numpy.array(slant))
    absorbed = numpy.log([max(1.0 - row["albedo"], LEAST_ABSORBED) for row in rows])
    absorbing = numpy.exp((slopes[2] + 0.5 * absorbed) * diffuse + slopes[1] * numpy.array(slant))
    return numpy.array([absorbing if name == "absorbed" else usual for name in TERMS]).T


def law_of(rows, law):
    """Logarithms of the law."""
    terms = numpy.array([[term(row) for term in TERMS.values()] for row in rows])
    slopes = [law["diffuse"], law["slant"], law["absorbed_diffuse"]]
    return numpy.log(numpy.maximum((terms * factors(rows, slopes)) @ [law[name] for name in TERMS], 1e-5))


def error_law(rows, errors, deviations, lit=True):
    """Coefficients and slopes (those of the light if `lit`) by name; and the logarithm of each error with its variance. `deviations`: of the errors'
    squares, by the references' noise. Expectation maximisation: each error's logarithm is the mean that its measurement and the law leave."""
    terms = numpy.array([[term(row) for term in TERMS.values()] for row in rows])
    steps = numpy.linspace(-4.0, 4.0, 161)
    likely, variance = numpy.log(numpy.maximum(errors, 0.5 * deviations ** 0.5)), numpy.zeros(len(rows))
    law = dict.fromkeys([*TERMS, "diffuse", "slant", "absorbed_diffuse"], 0.0)
    slopes = numpy.zeros(3)
    for _ in range(60):
        lit_terms, values = terms * factors(rows, slopes), numpy.exp(likely)
        weights = 1.0 / values
        for _ in range(10):  # weights from the law and the value together: neither large nor small residuals rule
            coefficients = not_negative(lit_terms * weights[:, None], values * weights)
            weights = (numpy.maximum(lit_terms @ coefficients, 1e-4) * values) ** -0.5
        law.update(zip(TERMS, coefficients))
        expected = law_of(rows, law)
        if lit:  # a step of Gauss and Newton, shortened
            step = 1e-4
            tangent = numpy.array([law_of(rows, law | {name: law[name] + step}) - expected for name in ("diffuse", "slant", "absorbed_diffuse")]).T / step
            slopes = slopes + 0.7 * numpy.linalg.lstsq(tangent, likely - expected, rcond=None)[0]
            law.update(zip(("diffuse", "slant", "absorbed_diffuse"), slopes))
            expected = law_of(rows, law)
        spread = float(numpy.sqrt(((likely - expected) ** 2 + variance).mean()))
        possible = expected[:, None] + spread * steps
        chance = numpy.exp(-0.5 * (steps ** 2 + ((numpy.exp(2.0 * possible) - errors[:, None] ** 2) / deviations[:, None]) ** 2))
        chance = numpy.maximum(chance, 1e-300)
        chance /= chance.sum(axis=1, keepdims=True)
        likely = (chance * possible).sum(axis=1)
        variance = (chance * (possible - likely[:, None]) ** 2).sum(axis=1)
    return law, likely, variance


def shape_of(row):
    return max((shape for shape in SHAPES if row["name"].startswith(shape + "-")), key=len)


def law_and_spread(rows, errors, deviations, lit=True):
    """With the standard deviation of log(error / law) on shapes that the law was not fitted to, of those above the law: what errs less is no harm."""
    law, likely, variance = error_law(rows, errors, deviations, lit)
    shapes = numpy.array([shape_of(row) for row in rows])
    squares = []
    for shape in sorted(set(shapes)):
        left_out = shapes == shape
        others, _, _ = error_law([r for r, out in zip(rows, left_out) if not out], errors[~left_out], deviations[~left_out], lit)
        expected = law_of([r for r, out in zip(rows, left_out) if out], others)
        above = likely[left_out] > expected
        squares.extend(((likely[left_out] - expected) ** 2 + variance[left_out])[above])
    return law | {"spread": float(numpy.mean(squares) ** 0.5)}


def deviation_of_square(row):
    """Of a measured error, by the reference's noise over the patches: its own and its product with the difference."""
    noise, patches = row["reference_error"], row["patches"]
    return float(numpy.hypot(1.5 * (2.0 / patches) ** 0.5 * noise ** 2, 2.0 * row["error"] * noise / patches ** 0.5)) + 1e-5


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


def first_of_each(rows):
    """A row of every scene."""
    scenes = {}
    for row in rows:
        scenes.setdefault(row["name"], row)
    return list(scenes.values())


def laws_of(name, answered):
    """Error, seconds and the spread of the seconds of one model."""
    rows = [r for r in answered if r["model"] == name]
    if name == "montecarlo":
        scenes = first_of_each(answered)
        noise = numpy.array([r["reference_error"] * (r["reference_photons"] / r["patches"]) ** 0.5 for r in scenes])
        return law_and_spread(scenes, noise, 1e-3 * noise ** 2, lit=False), *cost_law(rows, [r["cpu_seconds"] / r["photons"] for r in rows], PER_PHOTON)
    usual = [r for r in rows if r["tolerance"] > EXACT] or rows
    exact = [r for model in (name, SAME_PHYSICS.get(name))
             for r in first_of_each(r for r in answered if r["model"] == model and r["tolerance"] <= EXACT)]
    errors = numpy.array([r["error"] for r in exact])
    return (law_and_spread(exact, errors, numpy.array([deviation_of_square(r) for r in exact])),
            *cost_law(usual, [r["cpu_seconds"] for r in usual], list(LOGARITHMS)))


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
        error["diffuse"] += float(numpy.log(MARGIN_UNDER_SKY.get(name, 1.0)))
        lines.append(f'    {{"{name}",\n     {text_of(error)},\n'
                     f"     {text_of(seconds)},\n     {probe.get(name, 0.0):.4g}}},\n")
        print(f"{name}: {len(own)} rows, error within a factor of {numpy.exp(error['spread']):.2f}, "
              f"seconds within {numpy.exp(spread):.2f} (one standard deviation)")
    thickness = [r["thickness_over_mean_free_path"] for r in answered]
    albedo = [min(r["albedo"], 1.0 - LEAST_ABSORBED) for r in answered]
    arguments.table.write_text(
        "// Written by studies/fit_choice.py: do not edit. Errors, seconds and the probe's seconds of model_table.h.\n"
        f"constexpr MeasuredRange range{{{min(thickness):.4g}, {max(thickness):.4g}, {min(albedo):.4g}, {max(albedo):.5g},\n"
        f"                               {max(r['contrast'] for r in answered):.4g}, {max(r['slant'] for r in answered):.4g}}};\n"
        f"constexpr std::array<MeasuredModel, {len(lines)}> models{{{{\n{''.join(lines)}}}}};\n")
    print(arguments.table)


if __name__ == "__main__":
    sys.exit(main())

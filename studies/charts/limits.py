"""`kappamu-studies limits`."""
from charts.common import cross, fine_percent, flat, percent, short


def iterations_or_failure(row):
    return f"{'' if row['ended'] == 'converged' else 'not in '}{row['iterations']}"


def sentences(rows):
    """What the program reports of each case; a note that many make once only, known by its beginning."""
    text, shown = "\nWhat the program reports:\n\n", set()
    for row in rows:
        said = "".join(f" `{s}`" for s in row["warnings"]) or " no warning"
        for note in row["notes"]:
            if note[:12] not in shown:
                said += f", note `{note}`"
                shown.add(note[:12])
        text += f"- **{row['case']}**:{said}\n"
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
    "shared-errors": lambda rows: flat(rows, list(rows[0]), {k: fine_percent for k in (
        "stated error", "worst mean", "kappa within two deviations", "mu within two deviations")}),
    "objects": lambda rows: cross(rows, "object", "equivalent", lambda r: f"{iterations_or_failure(r)} "
                                                                          f"({short(r['smallest volume fraction'])})"),
}

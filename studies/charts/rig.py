"""`kappamu-studies calibration`, `rig` and `hdr`."""
from charts.common import dress, fine_percent, line, panels, percent, table, unique


def calibration(record):
    rows = record["rows"]
    figure, axes = panels(2, 2, 6.2, 4.2)
    for ax, title, label, found, stated, factor in (
            (axes[0], "camera calibration: error over the frame, at the sample's distance", "RMS [px]", "error_px",
             "predicted_px", 1), (axes[1], "focal length", "RMS error [%]", "focal_relative", "focal_predicted", 100)):
        for number, (key, name, style) in enumerate(((found, "against the truth", "-"), (stated, "as stated", "--"))):
            line(ax, number, [r["views"] for r in rows], [factor * r[key] for r in rows], name, style)
        dress(ax, title, "board views", label, "xy")
    return {"": figure}, {"": table(
        ["views", "error over the frame [px]", "stated", "focal length [%]", "stated"],
        [[r["views"]] + [f"{r[k]:.2f}" for k in ("error_px", "predicted_px")]
         + [f"{100 * r[k]:.2f}" for k in ("focal_relative", "focal_predicted")] for r in rows])}


def rig(record):
    parts = {name: [r for r in record["rows"] if r["part"] == name] for name in ("views", "exposures")}
    figure, axes = panels(2, 2, 6.2, 4.2)
    for ax, name, key, title, label in ((axes[0], "views", "boards", "calibration views", "board views"),
                                        (axes[1], "exposures", "exposures", "exposures", "exposures of a pattern")):
        for quantity, number in (("μ", 1), ("κ", 0)):
            field = "log_mu" if quantity == "μ" else "log_kappa"
            for end, found, style in (("", "found", "-"), ("_predicted", "predicted", "--")):
                line(ax, number, [r[key] for r in parts[name]], [100 * r[field + end] for r in parts[name]],
                     f"{quantity}, {found}", style)
        dress(ax, title, label, "change of the median voxel [%]", "y")
    changes = lambda r: [fine_percent(r[k]) for k in ("value_relative", "log_kappa", "log_kappa_predicted", "log_mu",
                                                      "log_mu_predicted")] + [f"{r['validation_E']:.1e}"]
    head = ["a measurement", "κ", "predicted", "μ", "predicted", "validation E"]
    return {"": figure}, {
        "-views": table(["boards, planes", "refused", "seen face [camera px]", "lit face [projector px]",
                         "turn [degrees]"] + head,
                        [[f"{r['boards']}, {r['planes']}", r["refused"]]
                         + [f"{r[k]:.2f}" for k in ("camera_px", "projector_px", "turn_degrees")] + changes(r)
                         for r in parts["views"]]),
        "-exposures": table(["exposures", "scale"] + head,
                            [[r["exposures"], fine_percent(r["scale_relative"])] + changes(r)
                             for r in parts["exposures"]])}


def hdr(record):
    rows = record["rows"]
    figure, axes = panels(3, 1, 9, 5)
    for ax, key, title, label in ((axes[0], "relative_rms", "Radiance, four decades",
                                   "relative error (root mean square)"),
                                  (axes[1], "dark_rms", "Radiance, darkest decade",
                                   "relative error (root mean square)"), (axes[2], "seconds", "Merge", "CPU seconds")):
        for number, method in enumerate(unique(rows, "method")):
            some = [r for r in rows if r["method"] == method]
            line(ax, number, [r["exposures"] for r in some], [r[key] for r in some], method)
        dress(ax, title, "exposures from 1/30 s to 8 s", label, "y", "outside")
    at = {(r["method"], r["exposures"]): r for r in rows}
    methods = unique(rows, "method")
    return {"": figure}, {"": table(
        ["exposures"] + methods + [f"{m}, darkest decade" for m in methods] + [f"{m}, CPU" for m in methods],
        [[n] + [percent(at[m, n][key], 1) for key in ("relative_rms", "dark_rms") for m in methods]
         + [f"{1e3 * at[m, n]['seconds']:.0f} ms" for m in methods] for n in unique(rows, "exposures")])}

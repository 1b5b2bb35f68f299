"""`kappamu-studies fur`: shells against rays."""
import pathlib

import matplotlib.pyplot as plt
import numpy

from charts.common import COLOURS, MARKS, dress, flat, panels, provenance, unique

GAP = 4  # pixels between pictures of a sheet


def reference(record):
    """Errors of pictures by shells against pictures by rays, and what multiple scattering adds."""
    rows = record["rows"]
    lights = unique(rows, "light")
    figure, (errors, scattering) = panels(2, 2, 5.6, 4.2)
    places = numpy.arange(len(lights))
    kinds = [("error of pixels", "above"), ("of blocks of 16", "above"), ("error of pixels", "grazing"), ("of blocks of 16", "grazing")]
    at = {(row["light"], row["view"]): row for row in rows}
    for number, (name, view) in enumerate(kinds):
        errors.plot(places, [100 * at[light, view][name] for light in lights], MARKS[number],
                    color=COLOURS[number], label=f"{name.removeprefix('error of ').removeprefix('of ')}, {view}")
    for number, view in enumerate(("above", "grazing")):
        scattering.plot(places, [at[light, view]["all scattering over once"] for light in lights], MARKS[number],
                        color=COLOURS[number], label=view)
    dress(errors, "shells against the integral along rays", "", "mean relative error [%]", "")
    dress(scattering, "all scattering over light scattered once", "", "ratio", "")
    for ax in (errors, scattering):
        ax.set_xticks(places, lights, rotation=15)
    return {"": figure}, {"": provenance(record) + "\n" + flat(rows, list(rows[0]))}


def transfer(record):
    """Errors of light by bands, at the most rays that all bands have."""
    rows = record["rows"]
    rays = max(row["rays"] for row in rows if row["bands"] == 1)
    figure, axes = panels(2, 2, 5.6, 4.2)
    for ax, name, title in ((axes[0], "shells' error", "means of layers"), (axes[1], "texels' error", "texels")):
        for number, light in enumerate(unique(rows, "light")):
            of = sorted((row for row in rows if row["light"] == light and row["rays"] == rays), key=lambda row: row["bands"])
            ax.plot([row["bands"] for row in of], [100 * row[name] for row in of], MARKS[number] + "-",
                    color=COLOURS[number], label=light)
        dress(ax, f"{title}, {rays} rays", "bands", "mean relative error [%]", "y")
    return {"": figure}, {"": provenance(record) + "\n" + flat(rows, list(rows[0]))}


def numbers(record):
    """Rows, and the numbers beside them."""
    beside = "".join(f"{name}: {value:.3g}\n\n" for name, value in record.items() if isinstance(value, float))
    return {}, {"": provenance(record) + "\n" + flat(record["rows"], list(record["rows"][0])) + "\n" + beside}


def sheets(record):
    """The pictures of each of [K]'s figures on one sheet, as large as they were drawn."""
    made = {}
    def of(row):
        return row["picture"].split("-")[1]
    for figure in unique(record["rows"], of):
        names = [row["picture"] for row in record["rows"] if of(row) == figure]
        made["-" + figure] = sheet([plt.imread(pathlib.Path(record["folder"]) / f"{name}.png")[..., :3] for name in names])
    return made, {}


def sheet(pictures):
    """Two in a row."""
    height, width = pictures[0].shape[:2]
    columns = min(2, len(pictures))
    rows = -(-len(pictures) // columns)
    whole = numpy.ones((rows * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3))
    for k, picture in enumerate(pictures):
        y, x = (k // columns) * (height + GAP), (k % columns) * (width + GAP)
        whole[y:y + height, x:x + width] = picture
    figure = plt.figure(figsize=(whole.shape[1] / 100, whole.shape[0] / 100))
    ax = figure.add_axes([0, 0, 1, 1])
    ax.imshow(whole, interpolation="nearest")
    ax.axis("off")
    return figure

"""The papers' figures made again (`kappamu-studies figures`)."""
import pathlib

import matplotlib
import matplotlib.pyplot as plt
import numpy

from charts.common import dress, flat, line, panels, percent, provenance, table, unique

TILE_GAP = 4  # pixels, as studies/figures/picture_figures.cpp has it


def pictures(record):
    """A labelled plate for each figure, and one table of all cells that were compared."""
    drawn = {}
    for made in record["figures"]:
        plate = plt.imread(pathlib.Path(record["folder"]) / f"figures-{made['name']}.png")
        drawn["-" + made["name"]] = labelled(plate, made["rows"], made["columns"])
    compared = [row for row in record["rows"] if "error" in row]
    text = provenance(record) + "\n" + table(
        ["figure", "row", "column", "model", "from", "difference", "stated", "seconds"],
        [[row["figure"], row["row"], row["column"], row["model"], row["from"], percent(row["error"], 1),
          percent(row["stated"], 1), f"{row['seconds']:.1f}"] for row in compared])
    return drawn, {"": text}


def labelled(plate, rows, columns):
    height, width = plate.shape[:2]
    figure = plt.figure(figsize=((width + 30) / 100.0, (height + 26) / 100.0))
    ax = figure.add_axes([28.0 / (width + 30), 2.0 / (height + 26), width / (width + 30.0), height / (height + 26.0)])
    ax.imshow(plate, interpolation="nearest")
    ax.grid(False)
    for side in ax.spines.values():
        side.set_visible(False)
    across, down = (width + TILE_GAP) / len(columns), (height + TILE_GAP) / len(rows)
    ax.set_xticks([(k + 0.5) * across for k in range(len(columns))], columns, fontsize=7)
    ax.xaxis.tick_top()
    ax.set_yticks([(k + 0.5) * down for k in range(len(rows))], rows, rotation=90, va="center", fontsize=7)
    ax.tick_params(length=0, pad=2)
    return figure


def show(ax, values, title, low=None, high=None, colours="viridis"):
    picture = ax.imshow(values, cmap=colours, vmin=low, vmax=high, interpolation="nearest")
    ax.set_title(title, fontsize=7)
    ax.set(xticks=[], yticks=[])
    ax.grid(False)
    return picture


def rgb(faces, key):
    """Three channels beside each other as a colour, each over its largest."""
    stack = numpy.stack([numpy.array(face[key]) if isinstance(key, str) else numpy.array(face[key[0]][key[1]])
                         for face in faces], axis=-1)
    return (stack / stack.max(axis=(0, 1), keepdims=True)).clip(0.0, 1.0)


def samples(record):
    """[W] 11: E by number of images. [W] 10 and 12: κ and μ of the seen face beside the truth, and other light."""
    rows = record["rows"]
    figure, (ax,) = panels(1)
    for number, name in enumerate(unique(rows, "sample")):
        some = [r for r in rows if r["sample"] == name]
        line(ax, number, [r["n"] for r in some], [r["E"] for r in some], name)
    dress(ax, "[W] figure 11", "n, of n × n images", "E of single-voxel light", "y")
    names = unique(record["faces"], "sample")
    faces, axes = plt.subplots(len(names), 6, figsize=(9.0, 1.6 * len(names)), squeeze=False, constrained_layout=True)
    for place, name in zip(axes, names):
        of = sorted((f for f in record["faces"] if f["sample"] == name), key=lambda f: f["channel"])
        for ax, (key, title) in zip(place, ((("relit", "truth"), "unseen light: truth"), (("relit", "found"), "found"),
                                            ("true_kappa", "κ: truth"), ("kappa", "κ: found"),
                                            ("true_mu", "μ: truth"), ("mu", "μ: found"))):
            show(ax, rgb(of, key), title)
        place[0].set_ylabel(name, fontsize=8)
    text = provenance(record) + "\n" + flat(rows, ["sample", "n", "images", "E", "patches_E", "chi2", "seconds"])
    return {"": figure, "-faces": faces}, {"": text}


def weights(record):
    """[W] 13: an image, its prediction, a scan line, κ and μ of the face. [W] 14: slices by depth beside the truth."""
    fits = record["fits"]
    image = numpy.array(record["image"])
    middle = image.shape[0] // 2
    figure, axes = plt.subplots(len(fits), 5, figsize=(9.5, 1.7 * len(fits)), squeeze=False, constrained_layout=True)
    truth = record["truth"]
    ranges = {key: (min(numpy.min(s[key]) for s in truth), max(numpy.max(s[key]) for s in truth)) for key in ("kappa", "mu")}
    name_of = lambda fit: fit["variant"] if fit["variant"] == "default" else f"[W], λ = {fit['weight']:.0e}"
    for place, fit in zip(axes, fits):
        predicted = numpy.array(fit["image"])
        show(place[0], image, "(a) captured", 0.0, image.max(), "gray")
        show(place[1], predicted, "(b) predicted", 0.0, image.max(), "gray")
        place[2].plot(image[middle], color="#D55E00", linewidth=1.0)
        place[2].plot(predicted[middle], color="#0072B2", linewidth=1.0)
        place[2].set_title("(c) scan line", fontsize=7)
        place[2].tick_params(labelsize=6)
        for ax, key, title in ((place[3], "kappa", "(d) κ of the face"), (place[4], "mu", "(e) μ of the face")):
            show(ax, fit["slices"][0][key], title, *ranges[key])
        place[0].set_ylabel(name_of(fit), fontsize=7)
    depth = len(truth)
    shown = sorted({0, depth // 4, depth // 2, depth - 1})
    depths, axes = plt.subplots(2 * len(shown), len(fits) + 1, figsize=(1.5 * (len(fits) + 1), 3.0 * len(shown)),
                                squeeze=False, constrained_layout=True)
    for k, layer in enumerate(shown):
        for j, key in enumerate(("kappa", "mu")):
            place = axes[2 * k + j]
            show(place[0], truth[layer][key], "truth" if k + j == 0 else "", *ranges[key])
            place[0].set_ylabel(f"{'κ' if key == 'kappa' else 'μ'}, layer {layer + 1}", fontsize=7)
            for ax, fit in zip(place[1:], fits):
                show(ax, fit["slices"][layer][key], name_of(fit) if k + j == 0 else "", *ranges[key])
    names = ["variant", "weight", "E", "chi2", "kappa_error_face", "kappa_error_middle", "mu_error_face",
             "mu_error_middle", "solves"]
    return {"": figure, "-depth": depths}, {"": provenance(record) + "\n" + flat(record["rows"], names)}


def stairs(record):
    """[T] 4.1: exitance of a ball lit from its middle, over its mean."""
    maps = record["maps"]
    figure, axes = plt.subplots(len(maps) // 2, 2, figsize=(9.0, 1.8 * (len(maps) // 2)), squeeze=False, constrained_layout=True)
    norm = matplotlib.colors.Normalize(0.5, 1.5)
    for ax, made in zip(axes.flat, maps):
        drawn = ax.imshow(numpy.array(made["map"], float), cmap="jet", norm=norm, interpolation="nearest", aspect="auto")
        ax.set_title(f"{made['boundary']}, {made['across']} across", fontsize=8)
        ax.set(xticks=[], yticks=[], xlabel="longitude", ylabel="height")
        ax.grid(False)
    figure.colorbar(drawn, ax=list(axes.flat), shrink=0.8)
    return {"": figure}, {"": provenance(record) + "\n" + flat(record["rows"], list(record["rows"][0]))}

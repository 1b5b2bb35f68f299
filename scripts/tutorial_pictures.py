#!/usr/bin/env python3
"""Makes docs/images/tutorial-photographs.png and tutorial-volume.png from the demo's folder.

    scripts/tutorial_pictures.py [out/demo]
"""
import json
import pathlib
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

WHITE = 4095  # codes of 12 bits in files of 16


def photograph(ax, session, file, title):
    reader = vtkPNGReader()
    reader.SetFileName(str(session / file))
    reader.Update()
    image = reader.GetOutput()
    columns, rows, _ = image.GetDimensions()
    codes = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1)[::-1]
    ax.imshow(numpy.minimum(codes / WHITE, 1))
    ax.set_title(title, fontsize=8)
    ax.axis("off")


def photographs(session):
    frames = {p["id"]: p["frames"] for p in json.loads((session / "session.json").read_text())["patterns"]}
    shown = [("calibration/board_00.png", "printed board"), ("calibration/plane_00_projected.png", "projected board"),
             ("calibration/sample_front.png", "the sample, evenly lit"), ("calibration/white_2.png", "white target")]
    shown += [(frame["file"], f"pattern {pattern}, {frame['exposure_s']:.2g} s")
              for pattern, k in (("fit_03", 0), ("fit_03", 2), ("fit_03", 4), ("fit_11", 2)) for frame in [frames[pattern][k]]]
    figure, axes = plt.subplots(2, 4, figsize=(9.6, 3.9), layout="constrained")
    for ax, (file, title) in zip(axes.flat, shown):
        photograph(ax, session, file, title)
    return figure


def volume(run):
    voxel = json.loads((run / "measurements/measurements.json").read_text())["voxel_mm"]
    kappa, deviation = (numpy.load(run / f"fit/{name}_G.npy") for name in ("kappa", "std_kappa"))
    layers = [len(kappa) // 6, len(kappa) // 2, len(kappa) - 1]
    figure, axes = plt.subplots(2, 3, figsize=(7.5, 4.2), layout="constrained")
    for row, (field, label) in enumerate(((kappa, "κ [mm]"), (100 * deviation / kappa, "standard deviation [% of κ]"))):
        high = numpy.percentile(field[layers], 99.5)
        for ax, layer in zip(axes[row], layers):
            image = ax.imshow(field[layer], vmin=0 if row else None, vmax=high, cmap="magma" if row else "viridis")
            ax.set_title(f"z = {(layer + 0.5) * voxel:.2g} mm", fontsize=9)
            ax.axis("off")
        figure.colorbar(image, ax=axes[row], label=label)
    return figure


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/demo")
    images = pathlib.Path(__file__).parent.parent / "docs/images"
    for name, figure in (("photographs", photographs(folder / "session")), ("volume", volume(folder / "run"))):
        figure.savefig(images / f"tutorial-{name}.png", dpi=100, metadata={"Software": None})


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Draws polygrids as `kappamu-studies polygrid --write` leaves them: the faces on the surface, coloured by the scaled
Jacobian of their cells, and below it by what became of the six weights of [W] appendix B there.

    polygrid_picture.py PICTURE.png STEM...      STEM-faces.npy, STEM-jacobian.npy and STEM-weights.npy, y upwards
"""
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection


KINDS = np.array([[0.85, 0.85, 0.85], [0.85, 0.25, 0.2], [0.2, 0.3, 0.8]])  # usable, negative, ill-conditioned


def draw(axes, stem, weights):
    faces = np.load(f"{stem}-faces.npy").astype(float)[:, :, [0, 2, 1]] * [1, -1, 1]
    jacobian = np.load(f"{stem}-jacobian.npy")
    normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    azimuth = np.radians(-60)
    seen = normal @ [np.cos(azimuth), np.sin(azimuth), 0.27] > -0.2
    light = np.array([0.4, -0.8, 0.5])
    shade = 0.5 + 0.5 * np.clip(normal @ light / np.linalg.norm(light), 0, 1)
    kinds = np.load(f"{stem}-weights.npy")
    colour = (KINDS[kinds] if weights else plt.cm.viridis(jacobian)[:, :3]) * shade[:, None]
    axes.add_collection3d(Poly3DCollection(faces[seen], facecolors=colour[seen], edgecolors="k", linewidths=0.15))
    low, high = faces.reshape(-1, 3).min(0), faces.reshape(-1, 3).max(0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.1)
    axes.view_init(15, -60)
    axes.set_axis_off()
    axes.set_title(f"weights negative (red) {(kinds == 1).mean():.0%}, ill-conditioned (blue) {(kinds == 2).mean():.1%}"
                   if weights else f"{pathlib.Path(stem).name}: least {jacobian.min():.2f} on the surface", fontsize=9)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    stems = sys.argv[2:]
    figure = plt.figure(figsize=(4 * len(stems), 8.6))
    for i, stem in enumerate(stems):
        for row in (0, 1):
            draw(figure.add_subplot(2, len(stems), row * len(stems) + i + 1, projection="3d"), stem, row == 1)
    bar = figure.add_axes([0.35, 0.05, 0.3, 0.02])
    figure.colorbar(plt.cm.ScalarMappable(cmap="viridis"), cax=bar, orientation="horizontal", label="scaled Jacobian")
    figure.subplots_adjust(0, 0.08, 1, 0.95, 0, 0)
    figure.savefig(sys.argv[1], dpi=100)


if __name__ == "__main__":
    main()

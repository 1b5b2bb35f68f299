"""Exitance over objects, drawn (`kappamu-studies objects`)."""
import matplotlib
import matplotlib.pyplot as plt
import numpy
from matplotlib.collections import PolyCollection

from charts.objects import THESIS, THESIS_MODELS

# Of maps, in the order of a grid; a name that ends in another's comes first.
MAPPED = ("embedded", "grid", "polygrid", "boundary_integral", "montecarlo", "beam-diffusion", "better-dipole",
          "dipole-rotated", "dipole")


def object_map(name, values):
    """Exitance of a model and its difference from the reference, patch by patch, on the lit side and the far one."""
    # Of triangles: corners; exitance, its mean over the patch, the reference's.
    corners, exitance, mean, reference = values[:, :9].reshape(-1, 3, 3), values[:, 9], values[:, 10], values[:, 11]
    figure, axes = plt.subplots(2, 3, figsize=(9.0, 8.0), constrained_layout=True)
    top = float(reference.max())
    difference = 100.0 * (mean - reference) / reference.clip(1e-3 * top)
    for row, sign, side in ((axes[0], 1.0, "lit side"), (axes[1], -1.0, "far side")):
        for ax, shown, title, colours, norm in (
                (row[0], exitance, "exitance", "viridis", matplotlib.colors.LogNorm(0.02 * top, top)),
                (row[1], reference, "Monte Carlo, patches", "viridis", matplotlib.colors.LogNorm(0.02 * top, top)),
                (row[2], difference, "difference of patches [%]", "RdBu_r", matplotlib.colors.Normalize(-20.0, 20.0))):
            figure.colorbar(draw_surface(ax, f"{title}, {side}", corners, shown, sign, colours, norm), ax=ax, shrink=0.8)
    figure.suptitle(name)
    return figure


def draw_surface(ax, title, corners, shown, sign, colours, norm):
    """Triangles in their colours, seen from the light (sign 1) or from opposite it."""
    ahead, right, up = frame_of([sign * x for x in (3.0, 5.0, 8.0)])  # towards the light
    seen = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ ahead > 0.0
    order = numpy.flatnonzero(seen)[numpy.argsort(corners[seen].mean(axis=1) @ ahead)]
    outlines = numpy.stack([corners[order] @ right, corners[order] @ up], axis=-1)
    patches = PolyCollection(outlines, array=shown[order].clip(norm.vmin, norm.vmax), cmap=colours, norm=norm,
                             edgecolors="face", linewidths=0.2)
    ax.add_collection(patches)
    ax.set(title=title, aspect="equal", xticks=[], yticks=[])
    ax.autoscale_view()
    ax.grid(False)
    return patches


def map_grid(maps, titles, models):
    """A row for each scene, by title: exitance by model on the side away from the light, beside Monte Carlo's."""
    models = [model for model in models if any(f"{name}-{model}" in maps for name in titles.values())]
    figure, axes = plt.subplots(len(titles), 1 + len(models), squeeze=False, constrained_layout=True,
                                figsize=(10.0, (8.5 if len(models) > 4 else 9.2) * len(titles) / (1 + len(models))))
    for row, (title, name) in zip(axes, titles.items()):
        values = next(maps[f"{name}-{model}"] for model in models if f"{name}-{model}" in maps)
        top = float(values[:, 11].max())
        norm = matplotlib.colors.LogNorm(0.01 * top, top)
        for ax, model in zip(row, ["Monte Carlo, patches", *models]):
            if f"{name}-{model}" in maps or ax is row[0]:
                shown = maps.get(f"{name}-{model}", values)
                draw_surface(ax, model, shown[:, :9].reshape(-1, 3, 3), shown[:, 11 if ax is row[0] else 9], -1.0, "viridis", norm)
                ax.title.set_fontsize("x-small" if len(models) > 4 else "medium")
            else:
                ax.set_visible(False)
        row[0].set_ylabel(title, fontsize="x-small" if len(models) > 4 else "medium")
    return figure


def map_pictures(maps):
    """Figures by name: of a scene that one model has a map of its own, the others in grids."""
    models_of = {}
    for name in maps:
        model = next(model for model in MAPPED if name.endswith("-" + model))
        models_of.setdefault(name[:-len(model) - 1], []).append(model)
    for scene, models in models_of.items():
        if len(models) == 1:
            yield f"map-{scene}-{models[0]}", object_map(f"{scene}-{models[0]}", maps[f"{scene}-{models[0]}"])
    several = [scene for scene, models in models_of.items() if len(models) > 1]
    grids = {"thesis": {title: scene for title, scene in THESIS.items() if scene in several},
             "grid": {scene: scene for scene in several if scene not in THESIS.values()}}
    for grid, titles in grids.items():
        if titles:
            yield grid, map_grid(maps, titles, THESIS_MODELS if grid == "thesis" else MAPPED)


def frame_of(toward):
    """Three axes: towards the eye, right, up, y being up."""
    ahead = numpy.array(toward) / numpy.linalg.norm(toward)
    right = numpy.cross([0.0, 1.0, 0.0], ahead)
    right /= numpy.linalg.norm(right)
    return ahead, right, numpy.cross(ahead, right)

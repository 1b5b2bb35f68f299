"""Arrays with their names, units and axes: xarray's DataArray where xarray is installed, else a NumPy array."""
import functools
import sys

from .lazy import np, xarray


@functools.cache
def _labelled_type():
    class Labelled(np.ndarray):
        """A NumPy array with `dims` (names of its axes) and `attrs` (a dict with `units` and `long_name`)."""

        def __array_finalize__(self, parent):
            self.attrs = dict(getattr(parent, "attrs", {}))
            dims = getattr(parent, "dims", ())
            self.dims = dims if len(dims) == self.ndim else ()  # of a part, the axes are not known

    Labelled.__qualname__ = "Labelled"  # where pickle finds it
    return Labelled


def __getattr__(name):
    if name == "Labelled":
        return _labelled_type()
    raise AttributeError(f"module {__name__} has no attribute {name}")


def labelled(array, dims, units, long_name, coords=None):
    """`array` with labels; its memory is shared.

    Args:
        array: NumPy array.
        dims: a name for each axis.
        units: unit of the values; "1" for dimensionless.
        long_name: what the values are.
        coords: coordinates by axis, for xarray alone.
    """
    attrs = {"units": units, "long_name": long_name}
    if xarray() is not None:
        return xarray().DataArray(array, dims=dims, coords=coords, attrs=attrs, name=long_name)
    view = array.view(_labelled_type())
    view.dims, view.attrs = tuple(dims), attrs
    return view


def centres(count, voxel_mm):
    """Centres of `count` voxels along an axis [mm]."""
    return (np.arange(count) + 0.5) * voxel_mm


def volume(array, voxel_mm, units, long_name, leading=()):
    """A volume [..., z, y, x] with the centres of its voxels [mm]; `leading`: (axis, its labels), if any."""
    dims = [axis for axis, _ in leading] + ["z", "y", "x"]
    coords = {axis: list(labels) for axis, labels in leading}
    for axis, count in zip("zyx", array.shape[-3:]):
        coords[axis] = centres(count, voxel_mm)
    return labelled(array, dims, units, long_name, coords)


FACE_AXES = {"x": ("z", "y"), "y": ("z", "x"), "z": ("y", "x")}


def face_map(array, face, voxel_mm, units, long_name, leading=("pattern",)):
    """Maps [..., v, u] of a face, whose axes are named by the block's."""
    axes = FACE_AXES[face[0]]
    coords = {axis: centres(count, voxel_mm) for axis, count in zip(axes, array.shape[-2:])}
    return labelled(array, [*leading, *axes], units, long_name, coords)


def plain(array):
    """The NumPy array of what labelled() made, and of anything else as NumPy takes it."""
    module = sys.modules.get("xarray")  # not imported: nobody has made one
    return array.values if module is not None and isinstance(array, module.DataArray) else array

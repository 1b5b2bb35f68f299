"""Arrays with their names, units and axes: xarray's DataArray where xarray is installed, else a NumPy array."""
import functools
import sys

from .errors import InputError
from .lazy import np, xarray


@functools.cache
def _labelled_type():
    class Labelled(np.ndarray):
        """A NumPy array with `dims` (names of its axes) and `attrs` (a dict with `units` and `long_name`)."""

        def __array_finalize__(self, parent):
            self.attrs = dict(getattr(parent, "attrs", {}))
            dims = getattr(parent, "dims", ())
            self.dims = dims if len(dims) == self.ndim else ()  # of a part, the axes are not known

        def transpose(self, *axes):
            turned = super().transpose(*axes)
            turned.dims = ()  # nor of a transpose
            return turned

        def swapaxes(self, first, second):
            turned = super().swapaxes(first, second)
            turned.dims = ()
            return turned

        T = property(transpose)

        def __reduce__(self):
            make, arguments, state = super().__reduce__()
            return make, arguments, (state, self.dims, self.attrs)

        def __setstate__(self, state):
            values, self.dims, self.attrs = state
            super().__setstate__(values)

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


AXES = ("channel", "pattern", "z", "y", "x")  # in this order wherever they occur
SPELLINGS = {"mm": ("mm", "millimeter", "millimetre"), "1/mm": ("1/mm", "mm-1", "mm^-1", "mm**-1", "/mm")}


def plain(array, key="the array", units=None):
    """The NumPy array of what labelled() made, and of anything else as NumPy takes it.

    Labels are believed: InputError with `key` where axes stand in another order than AXES, or where units are stated that are
    not `units`.
    """
    module = sys.modules.get("xarray")  # not imported: nobody has made one
    of_xarray = module is not None and isinstance(array, module.DataArray)
    if not of_xarray and type(array).__name__ != "Labelled":
        return array
    known = [axis for axis in array.dims if axis in AXES]
    if known != sorted(known, key=AXES.index):
        raise InputError(f"{key} has the axes ({', '.join(map(str, array.dims))}); transpose it to "
                         f"({', '.join(sorted(known, key=AXES.index))})", key)
    stated = array.attrs.get("units")
    if units is not None and stated is not None and str(stated).replace(" ", "") not in SPELLINGS.get(units, (units,)):
        raise InputError(f"{key} states the units {stated}; it must be in {units}", key)
    return array.values if of_xarray else array

"""What the surface of a block sends out under each light pattern: the input of a fit."""
from __future__ import annotations

import dataclasses
import os

from . import _core
from .arrays import plain
from .errors import InputError, key_in
from .lazy import np


@dataclasses.dataclass
class Measurements:
    """Surface measurements of a block (docs/formats.md).

    Attributes:
        irradiance: on the lit face before Fresnel, relative to white, float32 [M][v][u].
        value: mean over each surface voxel of the seen face, float32 [channel][M][v][u]; [M][v][u] is one channel.
        variance: of `value`, its unit squared, the same shape, > 0 where used.
        shape: (nz, ny, nx) of the voxels to fit.
        voxel_mm: edge of a voxel [mm].
        eta: relative refractive index.
        lit_face, seen_face: "x-" ... "z+".
        seen_faces: the face of each pattern where they are seen on two opposite ones, the first being seen_face; else None.
        quantity: "exitance" or "radiance_normal".
        light: "collimated" or "diffuse".
        sides: "open" or "mirror".
        channels: names.
        camera_mm: {"z+": (x, y, z)}, where cameras stand before the seen faces [mm]; transport then predicts the radiance
            towards them. None: `value` is exitance.
        mask: uint8, the shape of `value`, 1 = use; None: all.
    """

    irradiance: object
    value: object
    variance: object
    shape: tuple
    voxel_mm: float
    eta: float = 1.3
    lit_face: str = "z-"
    seen_face: str = "z+"
    quantity: str = "exitance"
    light: str = "collimated"
    sides: str = "open"
    channels: list = None
    mask: object = None
    seen_faces: list = None
    camera_mm: dict = None

    def _fields(self):
        value = np.asanyarray(plain(self.value, "value"))

        def by_channel(key):
            given = getattr(self, key)
            if given is None:
                return None
            array = np.asanyarray(plain(given, key))
            if array.shape != value.shape:
                raise InputError(f"{key} has shape {list(array.shape)} where value has {list(value.shape)}", key)
            return array if array.ndim == 4 else array[np.newaxis]

        def three(key, given, kind):
            try:
                x, y, z = map(kind, given)
            except (TypeError, ValueError):
                raise InputError(f"{key} is {given!r}; it must be three numbers", key) from None
            return x, y, z

        names = self.channels
        if names is None:
            count = len(value) if value.ndim == 4 else 1
            names = ["grey"] if count == 1 else ["R", "G", "B"] if count == 3 else [f"c{i}" for i in range(count)]
        nz, ny, nx = three("shape", self.shape, int)
        cameras = self.camera_mm or {}
        if not hasattr(cameras, "items"):
            raise InputError('camera_mm must be a dict of places by face, such as {"z+": (x, y, z)}', "camera_mm")
        return {"grid": (nx, ny, nz), "voxel_mm": self.voxel_mm, "eta": self.eta,
                "lit_face": self.lit_face, "seen_face": self.seen_face,
                "seen_faces": list(self.seen_faces or []),
                "camera_mm": {face: three("camera_mm", place, float) for face, place in cameras.items()},
                "quantity": self.quantity, "light": self.light, "sides": self.sides,
                "channels": [names] if isinstance(names, str) else list(names),
                "irradiance": np.asanyarray(plain(self.irradiance, "irradiance")),
                "value": by_channel("value"), "variance": by_channel("variance"), "mask": by_channel("mask")}


def read_measurements(folder: str | os.PathLike) -> Measurements:
    """Reads a folder with measurements.json, or the measurements of a run.

    Returns:
        Measurements: float32 arrays.

    Raises:
        InputError: naming file and field.
    """
    fields = _core.read_measurements(os.fspath(folder))
    nx, ny, nz = fields.pop("grid")
    return Measurements(shape=(nz, ny, nx), **fields)


def write_measurements(folder: str | os.PathLike, measurements: Measurements) -> None:
    """Writes Measurements as a folder that `kappamu fit` reads. Raises InputError naming the field that is wrong."""
    try:
        _core.write_measurements(os.fspath(folder), measurements._fields())
    except InputError as error:
        fields = [field.name for field in dataclasses.fields(Measurements)]
        raise InputError(str(error), error.key or key_in(str(error), fields)) from None

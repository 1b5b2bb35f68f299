"""Volumes of κ and μ: read and written in every format the program knows."""
from __future__ import annotations

import dataclasses
import os
import pathlib

from . import _core
from .arrays import plain, volume
from .errors import InputError
from .lazy import np

# What a volume file may hold of every channel: unit and meaning.
QUANTITIES = {
    "kappa": ("mm", "diffusion coefficient"),
    "mu": ("1/mm", "absorption coefficient"),
    "std_kappa": ("mm", "standard deviation of kappa"),
    "std_mu": ("1/mm", "standard deviation of mu"),
    "resolution_kappa": ("1", "share of the variance of log kappa that the data removed"),
    "resolution_mu": ("1", "share of the variance of log mu that the data removed"),
    "sensitivity": ("1", "how strongly the data constrain the voxel"),
    "correlation": ("1", "correlation of log kappa and log mu"),
}


@dataclasses.dataclass
class Volumes:
    """κ and μ of a sample, all channels on one grid.

    Attributes:
        kappa: diffusion coefficient [mm], float [channel][z][y][x], > 0.
        mu: absorption coefficient [1/mm], the same shape, >= 0.
        voxel_mm: edge of a voxel [mm].
        channels: names, such as ["R", "G", "B"].
        eta: relative refractive index, or None.
        std_kappa, std_mu, resolution_kappa, resolution_mu, sensitivity: the same shape, or None.
        metadata: provenance, text by text.
    """

    kappa: object
    mu: object
    voxel_mm: float
    channels: list = dataclasses.field(default_factory=lambda: ["grey"])
    eta: object = None
    std_kappa: object = None
    std_mu: object = None
    resolution_kappa: object = None
    resolution_mu: object = None
    sensitivity: object = None
    metadata: dict = dataclasses.field(default_factory=dict)

    def channel(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """(kappa, mu) of a channel, NumPy [z][y][x], without a copy."""
        if name not in self.channels:
            raise InputError(f"channel '{name}' is not among {', '.join(self.channels)}", "channel")
        at = list(self.channels).index(name)
        return tuple(np.asarray(plain(volume))[at] for volume in (self.kappa, self.mu))


def _joined(arrays, voxel_mm, channels, key):
    """The channels' volumes [z][y][x] as one array; a single channel's memory is kept."""
    if not arrays:
        return None
    joined = arrays[0][np.newaxis] if len(arrays) == 1 else np.stack(arrays)
    return volume(joined, voxel_mm, *QUANTITIES[key], leading=[("channel", channels)])


def read_volume(path: str | os.PathLike, max_voxels: int | None = None) -> Volumes:
    """Reads κ and μ from a .vdb file, a folder with volume.json, or a run or fit folder.

    Args:
        path: file or folder.
        max_voxels: most numbers that the file may hold in all its volumes together (default 100,000,000).

    Returns:
        Volumes: float64 [channel][z][y][x].

    Raises:
        InputError: naming file and grid of what is missing or damaged.
    """
    found = _core.read_volume(os.fspath(path), _core.default_max_voxels if max_voxels is None else int(max_voxels))
    channels, voxel_mm = found.pop("channels"), found.pop("voxel_mm")
    eta, metadata = found.pop("eta"), found.pop("metadata")
    arrays = {key: _joined(arrays, voxel_mm, channels, key) for key, arrays in found.items()}
    return Volumes(voxel_mm=voxel_mm, channels=channels, eta=eta, metadata=metadata, **arrays)


def write_volume(path: str | os.PathLike, volumes: Volumes, format: str | None = None) -> list[str]:
    """Writes κ and μ: .vdb and .vti by the name's ending, a folder for `vol` (Mitsuba) and `npy`.

    Args:
        path: file or folder to write.
        volumes: Volumes, or anything with their attributes, such as a Fit.
        format: "vdb", "vti", "vol" or "npy"; by itself from the ending of `path`, npy where it has none.

    Returns:
        list[str]: the files written; for npy the folder.

    Raises:
        InputError: for κ that is not positive, μ that is negative or NaN, or shapes that differ.
    """
    if not all(hasattr(volumes, name) for name in ("kappa", "mu", "channels", "voxel_mm")):
        raise InputError(f"volumes must be kappamu.Volumes or a Fit, not {type(volumes).__name__}", "volumes")
    ending = pathlib.PurePath(path).suffix.lstrip(".")
    fields = {"channels": list(volumes.channels), "voxel_mm": float(volumes.voxel_mm),
              "eta": volumes.eta, "metadata": dict(getattr(volumes, "metadata", {}))}
    for key in ("kappa", "mu", "std_kappa", "std_mu", "resolution_kappa", "resolution_mu", "sensitivity"):
        values = getattr(volumes, key, None)
        if values is None:
            continue
        array = np.asarray(plain(values, key, QUANTITIES[key][0]))
        fields[key] = list(array if array.ndim == 4 else array[np.newaxis])
    return _core.write_volume(os.fspath(path), format or ending or "npy", fields)


def read_image(path: str | os.PathLike) -> np.ndarray:
    """Reads a photograph or picture.

    Returns:
        numpy.ndarray: [y][x][channel], R, G, B or one channel: float32 of .exr and .hdr files, else the codes as uint16.
    """
    return _core.read_image(os.fspath(path))

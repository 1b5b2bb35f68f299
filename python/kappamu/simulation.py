"""From κ, μ and light to exitance, in arrays."""
from __future__ import annotations

import dataclasses
import json
import numbers
import os
import typing

from . import _core
from .arrays import face_map, plain, volume
from .errors import InputError, key_in, warn
from .lazy import np
from .progress import listener
from .volumes import read_volume

if typing.TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclasses.dataclass(repr=False)
class Exitance:
    """What leaves a block under each pattern.

    Attributes:
        exitance: by face ("x-" ... "z+"): flux per area, float64 [M][v][u], in the unit of the irradiance.
        standard_error: the same of Monte Carlo, else empty.
        fluence: fluence rate, float64 [M][z][y][x], where it was asked for, else None.
        fluence_error: its standard error, of Monte Carlo.
        report: what `kappamu forward` writes to summary.json: balance of power, iterations, residual, seconds.
        converged: whether the tolerance was met.
    """

    exitance: dict
    standard_error: dict
    fluence: object
    fluence_error: object
    report: dict
    converged: bool

    def __getitem__(self, face):
        return self.exitance[face]

    def __repr__(self):
        faces = ", ".join(f"{face} {list(values.shape)}" for face, values in self.exitance.items())
        return f"<kappamu.Exitance of the faces {faces}{'' if self.converged else '; not converged'}>"


def _coefficient(given, channel, key, max_voxels):
    """An array, or the coefficient `key` of a .vdb file or volume folder, or the array of a .npy file."""
    if isinstance(given, (str, os.PathLike)):
        if str(given).endswith(".npy"):
            try:
                return np.load(given, allow_pickle=False), None
            except (OSError, ValueError) as error:
                raise InputError(f"{given}: is not an array that can be read ({error})", key) from None
        found = read_volume(given, max_voxels)
        if channel is None and len(found.channels) > 1:
            raise InputError(f"{given}: has several channels; choose one with channel", "channel")
        pair = found.channel(found.channels[0] if channel is None else channel)
        return pair[0 if key == "kappa" else 1], found.voxel_mm
    return plain(given, key, {"kappa": "mm", "mu": "1/mm"}[key]), None


def forward(kappa: ArrayLike | str | os.PathLike, mu: ArrayLike | str | os.PathLike, *, voxel_mm: float | None = None,
            irradiance: ArrayLike | None = None, direction: tuple[float, float, float] | None = None, points=(),
            lit_face: str = "z-", eta: float = 1.3, sides: str = "open", source: str | None = None,
            convention: str = "physical", method: str = "multigrid", fluence: bool = False, tolerance: float = 1e-6,
            max_iterations: int = 200, precision: str = "single", photons: int = 1_000_000, anisotropy: float = 0.0,
            model_tolerance: float = 0.05, channel: str | None = None, max_voxels: int | None = None,
            device: str = "auto", seed: int = 1, progress=None) -> Exitance:
    """Solves ∇·(κ∇φ) − μφ = −S on the voxels given and returns what leaves each face.

    Args:
        kappa: diffusion coefficient 1/(3(mu + sigma_s')) [mm], [z][y][x], > 0; or a .vdb, .npy or folder.
        mu: absorption coefficient [1/mm], the same shape, >= 0.
        voxel_mm: edge of a voxel [mm]; .vdb files bring their own.
        irradiance: on the lit face before Fresnel, [M][v][u] or [v][u], any unit: [y][x] on z faces, [z][x] on y faces,
            [z][y] on x faces.
        direction: (x, y, z) in which the light travels in air; by itself along the normal.
        points: isotropic sources inside, (x, y, z) or (x, y, z, power) each [mm]; each is one more pattern.
        lit_face: "x-" ... "z+".
        eta: relative refractive index.
        sides: "open" (Robin) or "mirror" (no flux).
        source: "first-collision" (a collimated beam) or "boundary" (diffuse entry); by itself what the convention takes.
        convention: "physical" or "wang2008".
        method: a key of kappamu.forward_methods().
        fluence: also return the fluence rate.
        tolerance: relative residual to reach for every pattern.
        max_iterations: iterations allowed.
        precision: "single" or "double" storage.
        photons: of method "montecarlo", per pattern.
        anisotropy: g of its phase function.
        model_tolerance: of method "auto": relative error against transport.
        channel: of a file with several.
        max_voxels: most numbers that a file may hold.
        device: "auto", "reference", or part of an OpenCL device's name.
        seed: wherever chance enters.
        progress: function of (stage, fraction, detail), or True for a bar of tqdm.

    Returns:
        Exitance: the maps of all six faces; `light["z+"]` is one.

    Raises:
        InputError: with the key of the argument at fault.
    """
    kappa, voxel_of_file = _coefficient(kappa, channel, "kappa", max_voxels)
    mu, _ = _coefficient(mu, channel, "mu", max_voxels)
    if voxel_mm is None:
        voxel_mm = voxel_of_file
    if voxel_mm is None:
        raise InputError("voxel_mm is missing; arrays do not hold the edge of a voxel", "voxel_mm")
    if not isinstance(voxel_mm, numbers.Real) or isinstance(voxel_mm, bool):
        raise InputError(f"voxel_mm is {voxel_mm!r}; it must be one number, the edge of cubic voxels [mm]", "voxel_mm")
    if voxel_of_file is not None and abs(voxel_mm - voxel_of_file) > 1e-6 * voxel_of_file:
        raise InputError(f"voxel_mm is {voxel_mm} but the file's is {voxel_of_file}; leave it out", "voxel_mm")
    if source is None:
        source = "boundary" if convention == "wang2008" else "first-collision"
    try:
        points = [tuple(map(float, point)) for point in points]
    except (TypeError, ValueError):
        raise InputError("points must be a list of (x, y, z) or (x, y, z, power) [mm]", "points") from None
    if any(len(point) not in (3, 4) for point in points):
        raise InputError("each of points must be (x, y, z) or (x, y, z, power) [mm]", "points")
    points = [point + (1.0,) * (4 - len(point)) for point in points]
    options = {"voxel_mm": float(voxel_mm), "irradiance": plain(irradiance, "irradiance"), "direction": direction, "points": points,
               "lit_face": lit_face, "eta": eta, "sides": sides, "source": source, "convention": convention, "method": method, "fluence": fluence,
               "tolerance": tolerance, "max_iterations": max_iterations, "precision": precision, "photons": photons,
               "anisotropy": anisotropy, "model_tolerance": model_tolerance, "device": device, "seed": seed}
    try:
        found = _core.forward(kappa, mu, options, listener(progress))
    except InputError as error:
        raise InputError(str(error), error.key or key_in(str(error), ("kappa", "mu", *options))) from None

    def maps(by_face, name):
        return {face: face_map(values, face, voxel_mm, "unit of irradiance", name) for face, values in by_face.items()}

    def field(values, name):
        if values is None:
            return None
        return volume(values, voxel_mm, "unit of irradiance", name, leading=[("pattern", range(len(values)))])

    report = json.loads(found["summary"])
    if not report["converged"]:
        warn("the tolerance was not met: the maps are approximate; raise max_iterations or tolerance, or take precision double")
    return Exitance(maps(found["exitance"], "exitance"), maps(found["standard_error"], "standard error of the exitance"),
                    field(found["fluence"], "fluence rate"), field(found["fluence_error"], "standard error of the fluence"),
                    report, report["converged"])


def forward_methods() -> dict[str, str]:
    """The methods of forward(): a sentence by name."""
    return dict(_core.forward_methods())

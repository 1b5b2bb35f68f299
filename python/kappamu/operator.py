"""The discrete diffusion operator of a block, for people who bring their own inverse.

A φ = b with A symmetric positive definite: its own adjoint. φ is the fluence rate [z][y][x], b the power that enters each voxel
[mm² times the unit of irradiance]. docs/theory.md, sections 2 and 3.
"""
from __future__ import annotations

import operator
import typing

from . import _core
from .arrays import plain
from .errors import InputError, key_in
from .lazy import np

if typing.TYPE_CHECKING:
    from numpy.typing import ArrayLike


def _face(name):
    if not isinstance(name, str):
        raise InputError(f"face is {name!r}; it must be x-, x+, y-, y+, z- or z+", "face")
    return name


class Light:
    """The block under the patterns of one irradiance; the solution stays on the device.

    It is of the medium that the operator had when it was made; after another set_medium() it raises InputError.
    """

    def __init__(self, light):
        self._light = light

    @property
    def iterations(self) -> int:
        """Iterations of the slowest pattern."""
        return self._light.iterations

    def fluence(self) -> np.ndarray:
        """Fluence rate φ, float64 [M][z][y][x], in the unit of the irradiance."""
        return self._light.fluence()

    def exitance(self, face: str = "z+") -> np.ndarray:
        """Flux per area that leaves `face`, float64 [M][v][u]."""
        return self._light.exitance(_face(face))

    def gradient(self, weights: ArrayLike, face: str = "z+") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives of J = Σ weights · exitance(face), by one more solve: that of the adjoint.

        Args:
            weights: ∂J/∂exitance, [M][v][u].
            face: the face seen.

        Returns:
            tuple: ∂J/∂kappa [1/mm], ∂J/∂mu [mm] (both float64 [z][y][x]) and ∂J/∂irradiance [M][v][u]. They are those of the
            discrete model, exact to the solver's tolerance.
        """
        return self._light.gradient(plain(weights, "weights"), _face(face))


class DiffusionOperator:
    """Grid diffusion on nz × ny × nx cubic voxels, many patterns at once.

    Args:
        shape: (nz, ny, nx), as kappa.shape.
        voxel_mm: edge of a voxel [mm].
        kappa, mu: the medium, if it is known already; see set_medium.
        eta: relative refractive index.
        lit_face: where light enters, "x-" ... "z+".
        sides: "open" (Robin) or "mirror" (no flux).
        source: "first-collision" (a collimated beam) or "boundary" (diffuse entry).
        convention: "physical" or "wang2008".
        device: "auto", "reference" (serial, double precision), or part of an OpenCL device's name.
        precision: "single" or "double" storage.
        tolerance: relative residual of every solve.
        max_iterations: iterations allowed.

    Loads and fluences that are float64 in C order are used where they lie; others are converted. Medium and irradiance are
    copied, so that arrays may be changed afterwards. One thread works at a time; the interpreter's lock is released meanwhile.

    Raises:
        InputError: with the key of the argument at fault.
        NotConverged: where a solve does not reach the tolerance.
    """

    def __init__(self, shape: tuple[int, int, int], voxel_mm: float, kappa: ArrayLike | None = None, mu: ArrayLike | None = None, *,
                 eta: float = 1.3, lit_face: str = "z-", sides: str = "open", source: str = "first-collision",
                 convention: str = "physical", device: str = "auto", precision: str = "single", tolerance: float = 1e-6,
                 max_iterations: int = 200) -> None:
        try:
            self.shape = tuple(map(operator.index, shape))
        except TypeError:
            self.shape = ()
        if len(self.shape) != 3 or min(self.shape) < 1:
            raise InputError(f"shape is {shape!r}; it must be (nz, ny, nx), whole numbers from 1 on", "shape")
        if (kappa is None) != (mu is None):
            key = "kappa" if kappa is None else "mu"
            raise InputError(f"{key} is missing; a medium has both kappa and mu", key)
        options = {"voxel_mm": voxel_mm, "eta": eta, "lit_face": lit_face, "sides": sides, "source": source,
                   "convention": convention, "device": device, "precision": precision, "tolerance": tolerance,
                   "max_iterations": max_iterations}
        try:
            self._op = _core.Operator(self.shape, options)
        except InputError as error:
            raise InputError(str(error), error.key or key_in(str(error), options)) from None
        self.voxel_mm, self.lit_face = float(voxel_mm), lit_face
        if kappa is not None:
            self.set_medium(kappa, mu)

    def __repr__(self):
        return f"<kappamu.DiffusionOperator {'x'.join(map(str, self.shape))} voxels of {self.voxel_mm:g} mm on {self.backend}>"

    @property
    def backend(self) -> str:
        """"reference", or the OpenCL device's name and precision."""
        return self._op.backend

    def set_medium(self, kappa: ArrayLike, mu: ArrayLike) -> None:
        """Sets κ [mm] and μ [1/mm], [z][y][x], and rebuilds the preconditioner."""
        try:
            self._op.set_medium(plain(kappa, "kappa", "mm"), plain(mu, "mu", "1/mm"))
        except InputError as error:
            raise InputError(str(error), error.key or key_in(str(error), ("kappa", "mu"))) from None

    def medium_changed(self, light: Light) -> bool:
        """Whether set_medium() was called since `light` was solved."""
        return self._op.media != light._light.medium

    def solve(self, load: ArrayLike, start: ArrayLike | None = None) -> np.ndarray:
        """φ with A φ = load, float64 [M][z][y][x].

        Args:
            load: right-hand sides b, [M][z][y][x] or [z][y][x].
            start: first guess of φ, the same shape; zero by itself.
        """
        return self._op.solve(plain(load, "load"), plain(start, "start"))

    def apply(self, fluence: ArrayLike) -> np.ndarray:
        """A φ, [M][z][y][x]."""
        return self._op.apply(plain(fluence, "fluence"))

    def load(self, irradiance: ArrayLike) -> np.ndarray:
        """b of each pattern of irradiance [M][v][u] on the lit face, before Fresnel: [M][z][y][x]."""
        return self._op.load(plain(irradiance, "irradiance"))

    def exitance(self, fluence: ArrayLike, face: str = "z+") -> np.ndarray:
        """Flux per area that leaves `face` under φ [M][z][y][x]: [M][v][u]."""
        return self._op.exitance(plain(fluence, "fluence"), _face(face))

    def exitance_transposed(self, weights: ArrayLike, face: str = "z+") -> np.ndarray:
        """The transpose of exitance(): loads [M][z][y][x] for weights [M][v][u]."""
        return self._op.exitance_transposed(plain(weights, "weights"), _face(face))

    def illuminate(self, irradiance: ArrayLike) -> Light:
        """Solves for irradiance [M][v][u] on the lit face and returns the Light, with exitance and derivatives."""
        return Light(_core.Light(self._op, plain(irradiance, "irradiance")))

    def gradient(self, irradiance: ArrayLike, weights: ArrayLike,
                 face: str = "z+") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Light.gradient() in one call: two solves."""
        return self.illuminate(irradiance).gradient(weights, face)

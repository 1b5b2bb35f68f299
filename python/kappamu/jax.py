"""The exitance as a function that JAX differentiates by κ, μ and irradiance."""
import jax
import jax.numpy as jnp
import numpy as np


def exitance(operator, face="z+"):
    """A function (kappa, mu, irradiance) -> exitance of `face`, [M][v][u], with a custom_vjp.

    `operator` is a DiffusionOperator, whose medium each call sets. kappa [mm] and mu [1/mm] are [z][y][x], irradiance is
    [M][v][u]. The function may be used under jit and grad, not under vmap or forward mode. Give JAX 64 bits
    (jax.config.update("jax_enable_x64", True)) to keep the derivative's precision.
    """
    nz, ny, nx = operator.shape
    face_shape = {"x": (nz, ny), "y": (nz, nx), "z": (ny, nx)}[face[0]]

    def light(kappa, mu, irradiance):
        arrays = [np.array(a, dtype=np.float64) for a in (kappa, mu, irradiance)]
        operator.set_medium(*arrays[:2])
        return operator.illuminate(arrays[2])

    def solve(kappa, mu, irradiance):
        return light(kappa, mu, irradiance).exitance(face).astype(kappa.dtype)

    def derive(kappa, mu, irradiance, weights):
        found = light(kappa, mu, irradiance).gradient(np.array(weights, dtype=np.float64), face)
        return tuple(g.reshape(a.shape).astype(a.dtype) for g, a in zip(found, (kappa, mu, irradiance)))

    @jax.custom_vjp
    def function(kappa, mu, irradiance):
        shape = jax.ShapeDtypeStruct((irradiance.shape[0], *face_shape), jnp.asarray(kappa).dtype)
        return jax.pure_callback(solve, shape, kappa, mu, irradiance)

    def forward(kappa, mu, irradiance):
        return function(kappa, mu, irradiance), (kappa, mu, irradiance)

    def backward(kept, weights):
        shapes = tuple(jax.ShapeDtypeStruct(a.shape, a.dtype) for a in kept)
        return jax.pure_callback(derive, shapes, *kept, weights)

    function.defvjp(forward, backward)
    return function

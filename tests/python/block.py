"""A small block with an inclusion, and its measurements: what the tests of the package share."""
import numpy as np

import kappamu as km


def coefficients(nz=6, ny=10, nx=12, seed=1):
    """κ [mm] and μ [1/mm], float64 [z][y][x], smooth and of contrast 3."""
    random = np.random.default_rng(seed)
    z, y, x = np.meshgrid(*(np.linspace(0, 1, n) for n in (nz, ny, nx)), indexing="ij")
    a, b, c = random.uniform(1.0, 3.0, 3)
    wave = np.sin(a * np.pi * x) * np.cos(b * np.pi * y) * np.cos(c * np.pi * z)
    return np.exp(np.log(0.4) + 0.5 * wave), np.exp(np.log(0.02) - 0.5 * wave)


def patches(ny=10, nx=12, across=3):
    """Irradiance of across × across patches and of the whole face, float64 [M][y][x]."""
    light = [np.ones((ny, nx))]
    for v in np.array_split(np.arange(ny), across):
        for u in np.array_split(np.arange(nx), across):
            pattern = np.zeros((ny, nx))
            pattern[np.ix_(v, u)] = 1.0
            light.append(pattern)
    return np.array(light)


def measurements(seed=1, noise=0.005, voxel_mm=0.5):
    """(κ, μ, Measurements): what the block sends out, with noise of a known variance."""
    kappa, mu = coefficients(seed=seed)
    light = patches()
    seen = km.forward(kappa, mu, voxel_mm=voxel_mm, irradiance=light, device="reference")["z+"]
    clean = np.asarray(seen)
    deviation = noise * clean + 1e-6 * clean.max()
    random = np.random.default_rng(seed)
    value = clean + deviation * random.standard_normal(clean.shape)
    return kappa, mu, km.Measurements(light, value, deviation**2, kappa.shape, voxel_mm)

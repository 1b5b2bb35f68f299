#!/usr/bin/env python3
"""Errors of a simulated rig's measurements by octave of spatial frequency.

  studies/measurement_errors.py KAPPAMU RUN/measurements TRUTH

Solves for the truth of `kappamu simulate` under the light that was measured, on a grid twice as fine,
and prints for each channel how far the measured values are from that, in their stated deviations over
the root mean square of value by deviation, as inverse/problem/smooth_error.h counts them: root mean
square of what all patterns share, of the rest of each, and of white noise of the stated variances in
the octave. The figures in docs/calibration.md, "Errors that pixels share", are these.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np


def waves(n):
    """Rows are orthonormal cosines (DCT-II)."""
    k = np.arange(n)
    rows = np.sqrt(2 / n) * np.cos(np.pi * k[:, None] * (k + 0.5) / n)
    rows[0] /= np.sqrt(2)
    return rows


def twice(images):
    return images.repeat(2, axis=1).repeat(2, axis=2)


def predicted(kappamu, header, light, truth, channel):
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/light.npy", twice(light))
        subprocess.run([kappamu, "forward", "--kappa", truth / f"kappa_{channel}.npy", "--mu",
                        truth / f"mu_{channel}.npy", "--voxel", str(header["voxel_mm"] / 2), "--eta",
                        str(header["eta"]), "--lit-face", header["lit_face"], "--sides", header["sides"],
                        "--irradiance", f"{folder}/light.npy", "-o", f"{folder}/out"],
                       check=True, stdout=subprocess.DEVNULL)
        fine = np.load(f"{folder}/out/exitance_{header['seen_face']}.npy").astype(float)
    m, v, u = fine.shape
    return fine.reshape(m, v // 2, 2, u // 2, 2).mean((2, 4))


def main():
    kappamu, folder, truth = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    header = json.loads((folder / "measurements.json").read_text())
    light = np.load(folder / "irradiance.npy")
    values, variances = np.load(folder / "value.npy"), np.load(folder / "variance.npy")
    mask = np.load(folder / "mask.npy")
    print("channel, octave [1/voxel], shared by all patterns, own of each, white noise of the stated variances")
    for c, channel in enumerate(header["channels"]):
        value, used = values[c].astype(float), mask[c] != 0
        right = predicted(kappamu, header, light, truth, channel)
        deviation = np.sqrt(variances[c])
        signal = np.sqrt(((value / deviation)[used] ** 2).mean())
        error = np.where(used, (value - right) / deviation / signal, 0)
        m, v, u = error.shape
        spectrum = waves(v) @ error @ waves(u).T
        f = np.hypot(np.arange(v)[:, None] / (2 * v), np.arange(u) / (2 * u))
        own = spectrum - spectrum.mean(0)
        for low in [0.0] + [0.5 / 2**k for k in range(6, 0, -1)]:
            octave = (f >= low) & (f < (2 * low or 0.5 / 2**6))
            size = lambda waves: np.sqrt((waves**2).sum(-1).mean() / (v * u))
            white = np.sqrt(octave.sum() / (v * u)) / signal
            print(f"{channel}  {low:.4f}  {size(spectrum.mean(0)[octave]):.1e}  "
                  f"{size(own[:, octave]):.1e}  {white:.1e}")


if __name__ == "__main__":
    main()

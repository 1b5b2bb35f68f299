#!/usr/bin/env python3
"""Fits of pieces beside the single machine's, on measurements at hand and on blocks made here, as the rows of a table.

    compare_fits.py build/app/kappamu build/app/mpi/kappamu-mpi --work FOLDER [--exact] [--measurements FOLDER] [--before KAPPAMU_MPI]

By case: steps over all grids, their cost in solves, the weight, chi2 per value, and how far log kappa and log mu are from the
single machine's, root of the mean square over voxels. The yardstick is the single machine itself with other random probes (--seed 2):
what its own tolerance leaves open. --exact: all solves to 1e-4 (--no-loose-solves)."""
import argparse
import json
import os
import pathlib
import subprocess

import numpy as np


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)


def made(program, folder, shape, contrast, seen, patterns=8):
    """Measurements of a block in lumps of three voxels whose kappa differ by the contrast, with 0.5 % of noise."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(99)
    lumps = np.kron(random.random([n // 3 + 1 for n in shape]), np.ones((3, 3, 3)))[:shape[0], :shape[1], :shape[2]]
    np.save(folder / "k.npy", (0.25 * contrast ** (lumps - 0.5)).astype("<f4"))
    np.save(folder / "m.npy", (0.01 * 4 ** (0.5 - lumps)).astype("<f4"))
    light = np.kron(random.random((patterns, shape[1] // 3 + 1, shape[2] // 3 + 1)) > 0.6, np.ones((1, 3, 3)))
    np.save(folder / "irradiance.npy", light[:, :shape[1], :shape[2]].astype("<f4"))
    run(program, "forward", "--kappa", folder / "k.npy", "--mu", folder / "m.npy", "--irradiance", folder / "irradiance.npy", "--voxel",
        0.4, "--precision", "double", "-o", folder / "forward")
    value = np.load(folder / "forward" / f"exitance_{seen}.npy").astype("<f8")
    deviation = 0.005 * value + 1e-5 * value.max()
    np.save(folder / "value.npy", (value + deviation * random.standard_normal(value.shape)).astype("<f4")[None])
    np.save(folder / "variance.npy", (deviation ** 2).astype("<f4")[None])
    (folder / "measurements.json").write_text(json.dumps({
        "format": "kappamu-measurements", "version": 1, "voxel_mm": 0.4, "grid": list(shape[::-1]), "eta": 1.3, "lit_face": "z-",
        "seen_face": seen, "quantity": "exitance", "light": "collimated", "sides": "open", "channels": ["G"]}))
    return folder


def read(out, channel):
    fit = json.loads((out / "fit.json").read_text())
    report = next(c for c in fit["channels"] if c["name"] == channel)
    logs = [np.log(np.load(out / f"{name}_{channel}.npy")) for name in ("kappa", "mu")]
    return report, logs


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program")
    options.add_argument("mpi_program")
    options.add_argument("--work", type=pathlib.Path, required=True)
    options.add_argument("--measurements", type=pathlib.Path)
    options.add_argument("--channel", default="G")
    options.add_argument("--exact", action="store_true")
    options.add_argument("--before", help="another kappamu-mpi, of one rank")
    options.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4])
    options.add_argument("--grid", type=int, nargs=3, default=[24, 24, 12], metavar=("X", "Y", "Z"))
    a = options.parse_args()
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1",
                      OMPI_MCA_mpi_yield_when_idle="1")
    shape = tuple(a.grid[::-1])
    cases = {f"contrast {c:g}, {'behind' if seen == 'z+' else 'in front'}": (made(a.program, a.work / f"case_{c:g}_{seen[0]}{len(seen)}{i}",
                                                                                 shape, c, seen), "G")
             for i, (c, seen) in enumerate([(10, "z+"), (1e4, "z+"), (10, "z-")])}
    if a.measurements:
        cases = {"measurements": (a.measurements, a.channel), **cases}
    print("| case | program | steps | solves | weight | chi2 per value | log κ apart | log μ apart |\n|---|---|---|---|---|---|---|---|")
    for name, (folder, channel) in cases.items():
        single = ["fit", folder, "--channel", channel, "--model", "volume", "--precision", "double", "--uncertainty", 0]
        commands = {"one machine": [a.program, *single], "one machine, other probes": [a.program, "--seed", 2, *single]}
        for ranks in a.ranks:
            commands[f"{ranks} rank{'s' if ranks > 1 else ''}"] = ["mpirun", "-n", ranks, a.mpi_program, "fit", folder, "--channel", channel]
        if a.before:
            commands["before, 1 rank"] = ["mpirun", "-n", 1, a.before, "fit", folder, "--channel", channel]
        expected = None
        for k, (label, command) in enumerate(commands.items()):
            out = a.work / f"{folder.name}_{k}"
            run(*command, *(["--no-loose-solves"] if a.exact else []), "-o", out)
            report, logs = read(out, channel)
            expected = expected or logs
            apart = [f"{np.sqrt(np.mean((x - y) ** 2)):.2g}" for x, y in zip(logs, expected)]
            history = report["history"]
            steps = sum(h["step"] > 0 for h in history)
            solves = sum(history[-1][f"{kind}_solves"] for kind in ("forward", "adjoint", "refined"))
            print(f"| {name} | {label} | {steps} | {solves} | {report['weight']:.3g} | {report['chi2_per_value']:.3g} "
                  f"| {' | '.join(apart)} |", flush=True)


main()

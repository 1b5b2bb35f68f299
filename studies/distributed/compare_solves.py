#!/usr/bin/env python3
"""Solves of pieces beside the single machine's: whole commands on the same files, wall clock, processor time and memory, as the rows of a table.

    compare_solves.py build/app/kappamu build/app/mpi/kappamu-mpi --work FOLDER [--sizes 64 128] [--ranks 1 2] [--contrast 1e4]

Kappa is made of cells of four voxels whose logarithms are uniform between the square roots of 1/contrast and contrast. Two patterns
light it. Memory is the largest of one process. "apart" is the largest difference of the far face from the single machine's, of its largest value."""
import argparse
import os
import pathlib
import subprocess
import time

import numpy as np


def run(command):
    """Seconds of wall clock, seconds of processor and MB of the largest process."""
    start = time.time()
    process = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status):
        raise SystemExit(message)
    return time.time() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def made(folder, n, contrast):
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(7)
    cells = np.repeat(np.repeat(np.repeat(random.random([n // 4 + 1] * 3), 4, 0), 4, 1), 4, 2)[:n, :n, :n]
    np.save(folder / "k.npy", (0.25 * contrast ** (cells - 0.5)).astype("<f4"))
    np.save(folder / "m.npy", np.full((n, n, n), 0.01, "<f4"))
    light = np.zeros((2, n, n), "<f4")
    light[0] = 1
    light[1, :, : n // 2] = 1
    np.save(folder / "e.npy", light)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program")
    options.add_argument("distributed")
    options.add_argument("--work", type=pathlib.Path, required=True)
    options.add_argument("--sizes", type=int, nargs="+", default=[64, 128])
    options.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    options.add_argument("--contrast", type=float, default=1e4)
    a = options.parse_args()
    print("| voxels | program | wall s | processor s | MB of a process | apart |\n|---|---|---|---|---|---|")
    for n in a.sizes:
        case = a.work / str(n)
        made(case, n, a.contrast)
        volumes = ["--kappa", case / "k.npy", "--mu", case / "m.npy", "--voxel", "0.25", "--irradiance", case / "e.npy", "--tolerance", "1e-6"]
        commands = {"kappamu": [a.program, "forward", *volumes, "-o", case / "one"]}
        for ranks in a.ranks:
            commands[f"kappamu-mpi, {ranks} rank{'s' if ranks > 1 else ''}"] = [
                "mpirun", "--oversubscribe", "--allow-run-as-root", "-n", ranks, a.distributed, "forward", *volumes, "-o", case / f"ranks{ranks}"]
        for name, command in commands.items():
            wall, processor, memory = run(command)
            out = pathlib.Path(command[-1])
            faces = [np.load(next(folder.glob("**/*z+*.npy"))) for folder in (case / "one", out)]
            apart = np.abs(faces[1] - faces[0]).max() / faces[0].max()
            print(f"| {n}³ | {name} | {wall:.1f} | {processor:.1f} | {memory:.0f} | {apart:.1g} |", flush=True)


main()

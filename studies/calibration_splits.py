#!/usr/bin/env python3
"""Are a camera calibration's stated deviations true? Splits photographs of a board at random into
two halves, calibrates each with `kappamu calibrate`, and compares the differences of fx, fy, cx, cy
with the deviations that the two state: root mean squares over the splits, and their ratio.

    studies/calibration_splits.py FOLDER --board 9x6 --square 25 [--splits 40] [--kappamu PATH]

A ratio of 1 is right; above it the stated deviations are too small. The halves share the board: its
own bend and scale do not show. With --within LOW HIGH the exit code is 1 where a ratio lies outside.
Prints one line of a Markdown table. Python's standard library only."""

import argparse
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

names = ("fx", "fy", "cx", "cy")
numbers = 12  # of the lens, in the order of its covariance


def matrix(text, name):
    data = re.search(name + r":.*?data: \[(.*?)\]", text, re.S).group(1)
    return [float(value) for value in data.split(",")]


def calibrate(photographs, arguments):
    """fx, fy, cx, cy and their stated variances."""
    with tempfile.TemporaryDirectory() as folder:
        shots = pathlib.Path(folder, "shots")
        shots.mkdir()
        for photograph in photographs:
            (shots / photograph.name).symlink_to(photograph.resolve())
        command = [arguments.kappamu, "calibrate", shots, "-o", pathlib.Path(folder, "camera"),
                   "--board", arguments.board, "--square", arguments.square, "--follow-links"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(done.stderr.strip())
        text = pathlib.Path(folder, "camera", "camera.yml").read_text(encoding="utf-8")
    k = matrix(text, "camera_matrix")
    covariance = matrix(text, "covariance")
    return (k[0], k[4], k[2], k[5]), [covariance[i * (numbers + 1)] for i in range(4)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--board", required=True)
    parser.add_argument("--square", required=True)
    parser.add_argument("--splits", type=int, default=40)
    parser.add_argument("--kappamu", default="kappamu")
    parser.add_argument("--within", type=float, nargs=2, metavar=("LOW", "HIGH"))
    arguments = parser.parse_args()
    photographs = sorted(p for p in arguments.folder.iterdir()
                         if p.suffix.lower() in (".jpg", ".jpeg", ".png", ".tif", ".tiff"))
    half = len(photographs) // 2
    chance = random.Random(1)
    found, stated = [0.0] * 4, [0.0] * 4
    for _ in range(arguments.splits):
        chance.shuffle(photographs)
        (a, variance_a), (b, variance_b) = (
            calibrate(photographs[at:at + half], arguments) for at in (0, half))
        for i in range(4):
            found[i] += (a[i] - b[i]) ** 2 / arguments.splits
            stated[i] += (variance_a[i] + variance_b[i]) / arguments.splits
    cells = [arguments.folder.resolve().name, f"2 × {half}"]
    ratios = [math.sqrt(f / s) for f, s in zip(found, stated)]
    cells += [f"{math.sqrt(f):.2f} / {math.sqrt(s):.2f} = {r:.2f}"
              for f, s, r in zip(found, stated, ratios)]
    print("| set | views | " + " | ".join(names) + " |\n|---|---|---|---|---|---|")
    print("| " + " | ".join(cells) + " |")
    if arguments.within:
        low, high = arguments.within
        sys.exit(any(not low <= ratio <= high for ratio in ratios))


if __name__ == "__main__":
    main()

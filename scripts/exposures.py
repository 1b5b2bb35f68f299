#!/usr/bin/env python3
"""What the number of exposures does to kappa and mu: simulates, runs and scores the tiny sample, and prints the table of
docs/hdr.md.

    scripts/exposures.py OUT [KAPPAMU]     default build/app/kappamu; runs that OUT already has are not repeated
"""
import json
import pathlib
import subprocess
import sys

import numpy as np

if len(sys.argv) < 2:
    sys.exit(__doc__)
out = pathlib.Path(sys.argv[1])
kappamu = sys.argv[2] if len(sys.argv) > 2 else "build/app/kappamu"
print("| exposures | deviation of a measurement | stated deviation of κ, μ | found error of κ, μ | held-out E |")
print("|---|---|---|---|---|")
for count in (2, 3, 4, 6, 9):
    simulated, run = out / f"sim{count}", out / f"run{count}"
    times = np.geomspace(1 / 30, 8, count)
    if not simulated.exists():
        subprocess.run([kappamu, "simulate", "--sample", "tiny", "--patches", "3", "--holdout", "4", "-o", simulated,
                        "--exposures", *(f"{t:.6g}" for t in times)], check=True, stdout=subprocess.DEVNULL)
    if not (run / "fit" / "volume.vdb").exists():
        done = subprocess.run([kappamu, "run", simulated / "session", "-o", run, "--device", "reference"],
                              stdout=subprocess.DEVNULL).returncode
        if done not in (0, 3):
            sys.exit(f"exposures: kappamu run ended with {done}")
    scored = subprocess.run([kappamu, "--json", "score", run, "--truth", simulated / "truth"], check=True,
                            capture_output=True, text=True).stdout
    score = json.loads(scored.splitlines()[-1])

    def stated(quantity):
        ratios = [np.load(run / f"fit/std_{quantity}_{c}.npy") / np.load(run / f"fit/{quantity}_{c}.npy") for c in "RGB"]
        return f"{100 * np.median(ratios):.1f} %"

    values = np.load(run / "measurements/value.npy")
    deviation = np.median(np.sqrt(np.load(run / "measurements/variance.npy")) / values)
    print(f"| {count} | {100 * deviation:.2f} % | {stated('kappa')}, {stated('mu')} | "
          f"{100 * score['kappa_relative_error']:.1f} %, {100 * score['mu_relative_error']:.0f} % | "
          f"{score['holdout_E']:.1e} |", flush=True)

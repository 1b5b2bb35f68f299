#!/usr/bin/env python3
"""What the Python package adds to a fit: processor time in user mode of `kappamu fit` and of kappamu.fit on the same measurements,
in pairs that take turns in going first.

    PYTHONPATH=build/python overhead.py build/app/kappamu MEASUREMENTS [--pairs 5] [--option max_levels=1 ...]

Both write their files. The last line is the mean over the pairs of the share that Python's is above, and its standard error."""
import argparse
import resource
import subprocess
import sys
import tempfile

FIT = """import sys, kappamu as km
options = dict(pair.split("=", 1) for pair in sys.argv[3:])
km.fit(sys.argv[1], out=sys.argv[2], **{k: int(v) if v.isdigit() else v.split(",") if k == "channels" else v
                                 for k, v in options.items()})"""
FLAGS = {"max_levels": "--levels", "channels": "--channel", "stage_steps": "--stage-steps", "model": "--model", "weight": "--weight"}


def user_seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program")
    options.add_argument("measurements")
    options.add_argument("--pairs", type=int, default=5)
    options.add_argument("--option", action="append", default=[], help=f"of a fit, one of {', '.join(FLAGS)}")
    a = options.parse_args()
    flags = [text for pair in a.option for text in (FLAGS[pair.split("=")[0]], pair.split("=")[1])]
    shares = []
    for k in range(a.pairs):
        with tempfile.TemporaryDirectory() as folder:
            commands = {"program": [a.program, "fit", a.measurements, "-o", f"{folder}/program", *flags],
                        "package": [sys.executable, "-c", FIT, a.measurements, f"{folder}/package", *a.option]}
            order = list(commands) if k % 2 == 0 else list(commands)[::-1]
            seconds = {name: user_seconds(commands[name]) for name in order}
        shares.append(seconds["package"] / seconds["program"] - 1)
        print(f"pair {k + 1}: program {seconds['program']:.2f} s, package {seconds['package']:.2f} s", flush=True)
    mean = sum(shares) / len(shares)
    spread = (sum((s - mean) ** 2 for s in shares) / max(1, len(shares) - 1) / len(shares)) ** 0.5
    print(f"the package takes {100 * mean:.2f} % more, standard error {100 * spread:.2f} %")


main()

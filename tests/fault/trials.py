#!/usr/bin/env python3
"""Trials of what docs/limits.md promises of files: random SIGKILLs, flipped bits, failing calls.

Run by scripts/trials.sh, which builds the preload library. Each trial ends as done (new files), refused (one sentence,
old files) or as a failure, which is printed. Prints the table of docs/limits.md.
"""
import argparse
import contextlib
import json
import math
import os
import random
import select
import shutil
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

KINDS = ["write", "rename", "sync", "open", "place", "malloc", "thread"]
# Of the run that is disturbed and of the one whose files lie there before; one smoothing weight makes them quick.
QUICK = ["--device", "reference", "--uncertainty", "0"]
NEW = [*QUICK, "--lambda", "100"]
OLD = [*QUICK, "--lambda", "300"]
# Fields of records that differ from run to run of the same.
BY_TIME = {"seconds", "seconds_total", "memory_peak_bytes", "checksum"}
DONE = (0, 3)


def write_npy(file, shape, values):
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (63 - (10 + len(header)) % 64) + b"\n"
    file.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header +
                     struct.pack(f"<{len(values)}f", *values))


def read_npy(file):
    content = file.read_bytes()
    begin = 10 + struct.unpack("<H", content[8:10])[0]
    return struct.unpack(f"<{(len(content) - begin) // 4}f", content[begin:])


class Trials:
    def __init__(self, options):
        self.options = options
        self.work = Path(options.work).resolve()
        self.random = random.Random(options.seed)
        self.rows = []
        self.failures = []
        # No OpenCL driver: how it takes failing calls is not ours to promise.
        self.environment = dict(os.environ, OCL_ICD_VENDORS=str(self.work / "none"))

    # Inputs.

    def kappamu(self, arguments, count=None):
        environment = dict(self.environment)
        if count:
            environment.update(LD_PRELOAD=self.options.library, KAPPAMU_FAULT_COUNT=str(count))
        return subprocess.run([self.options.program, *arguments], env=environment, text=True, errors="replace",
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=900)

    @contextlib.contextmanager
    def server(self, arguments):
        """Yields a function that runs kappamu with these arguments and one fault, a fork of a loaded process each."""
        orders, results = os.pipe(), os.pipe()
        environment = dict(self.environment, LD_PRELOAD=self.options.library,
                           KAPPAMU_FAULT_SERVER=f"{orders[0]}:{results[1]}")
        with open(self.work / "stderr.txt", "a+", errors="replace") as said:
            process = subprocess.Popen([self.options.program, *arguments], env=environment, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.DEVNULL, stderr=said, pass_fds=(orders[0], results[1]),
                                       start_new_session=True)
            os.close(orders[0])
            os.close(results[1])

            def run(fault):
                said.truncate(0)
                os.write(orders[1], f"{fault}\n".encode())
                if not select.select([results[0]], [], [], 900)[0]:
                    sys.exit(f"trials: {arguments[0]} with {fault} does not end")
                code = int(os.read(results[0], 64) or sys.exit(f"trials: {arguments[0]} does not serve"))
                said.seek(0)
                return subprocess.CompletedProcess(arguments, code, "", said.read())

            try:
                yield run
            finally:
                os.killpg(process.pid, signal.SIGKILL)  # with a fork that does not end
                process.wait()
                os.close(orders[1])
                os.close(results[0])

    def made(self, arguments):
        result = self.kappamu(arguments)
        if result.returncode not in DONE:
            sys.exit("trials: " + result.stderr)

    def session(self):
        """The photographs of the sample 'tiny', three light patterns."""
        if not (self.work / "capture").exists():
            self.made(["simulate", "--sample", "tiny", "--seed", "3", "--patches", "2", "--holdout", "0", "--device",
                       "reference", "-o", str(self.work / "capture")])
        return self.work / "capture" / "session"

    def measurements(self):
        """Of a block of 8 x 6 x 5 voxels under four patterns, one channel."""
        folder = self.work / "measurements"
        if folder.exists():
            return folder
        nx, ny, nz, patterns = 8, 6, 5, 4
        light = [1.0 if (x >= 4) == bool(m % 2) and (y >= 3) == bool(m // 2) else 1e-3
                 for m in range(patterns) for y in range(ny) for x in range(nx)]
        voxels = [(x, y, z) for z in range(nz) for y in range(ny) for x in range(nx)]
        for name, values in [("kappa", [0.3 * (1 + 0.4 * math.sin(x) * math.cos(y + z)) for x, y, z in voxels]),
                             ("mu", [0.01 * (1 + 0.4 * math.cos(x + y)) for x, y, z in voxels])]:
            write_npy(self.work / (name + ".npy"), (nz, ny, nx), values)
        folder.mkdir()
        write_npy(folder / "irradiance.npy", (patterns, ny, nx), light)
        self.made(["forward", "--kappa", str(self.work / "kappa.npy"), "--mu", str(self.work / "mu.npy"), "--voxel",
                   "0.5", "--eta", "1.3", "--irradiance", str(folder / "irradiance.npy"), "--lit-face", "z-",
                   "--device", "reference", "-o", str(self.work / "forward")])
        exact = read_npy(self.work / "forward" / "exitance_z+.npy")
        noise = random.Random(1)
        write_npy(folder / "value.npy", (1, patterns, ny, nx), [v * noise.gauss(1, 0.01) for v in exact])
        write_npy(folder / "variance.npy", (1, patterns, ny, nx), [(0.01 * v) ** 2 for v in exact])
        (folder / "measurements.json").write_text(json.dumps(
            {"format": "kappamu-measurements", "version": 1, "voxel_mm": 0.5, "grid": [nx, ny, nz], "eta": 1.3,
             "lit_face": "z-", "seen_face": "z+", "quantity": "exitance", "light": "collimated", "sides": "open",
             "channels": ["R"]}))
        return folder

    # What a folder holds, times apart.

    @staticmethod
    def without_times(value):
        if isinstance(value, dict):
            return {k: Trials.without_times(v) for k, v in value.items() if k not in BY_TIME}
        if isinstance(value, list):
            # Hashes of files that hold times.
            if value and all(isinstance(v, dict) and "hash" in v for v in value):
                return [v["path"] if v["path"].endswith((".json", ".html")) else v for v in value]
            return [Trials.without_times(v) for v in value]
        return value

    @staticmethod
    def content(folder):
        files = {}
        for path in sorted(Path(folder).rglob("*")):
            name = str(path.relative_to(folder))
            if not path.is_file() or name == "run.lock" or path.suffix == ".html":
                continue
            if path.suffix == ".json":
                try:
                    files[name] = Trials.without_times(json.loads(path.read_text()))
                    continue
                except ValueError:
                    pass
            files[name] = path.read_bytes()
        return files

    @staticmethod
    def difference(found, expected):
        names = sorted(n for n in found.keys() | expected.keys() if found.get(n) != expected.get(n))
        return ", ".join(names[:5])

    def add(self, name, tried, outcome, seconds):
        self.rows.append((name, tried, outcome, seconds))
        print(f"{name}: {tried}; {outcome}; {seconds:.0f} s", flush=True)

    def fail(self, what):
        self.failures.append(what)
        print("FAILURE " + what, flush=True)

    # 1. Killed at random moments and started again.

    def kills(self, count, name, given, options, begun=None):
        """`begun`, a command, has filled the run folder before the first kill."""
        start = time.time()
        # One name throughout, since records and reports hold it.
        run = self.work / "killed"
        arguments = ["run", str(given), "-o", str(run), *options]
        self.clear(run)
        first = self.work / "begun"
        self.clear(first)
        if begun:
            self.made([begun, str(given), "-o", str(run)])
            shutil.copytree(run, first)
        began = time.time()
        self.made(arguments)
        whole = time.time() - began
        expected = self.content(run)
        done = runs = equal = 0
        while done < count:
            self.clear(run)
            if begun:
                shutil.copytree(first, run)
            for _ in range(min(count - done, self.random.randint(1, 6))):
                child = subprocess.Popen([self.options.program, *arguments], env=self.environment,
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                try:
                    child.wait(self.random.uniform(0.0, 0.9 * whole))
                    break
                except subprocess.TimeoutExpired:
                    child.kill()
                    child.wait()
                    done += 1
                if (run / "run.json").exists():
                    seen = self.kappamu(["verify", str(run)])
                    if seen.returncode != 0:
                        self.fail(f"{name}, kill {done}: verify says {seen.stdout} {seen.stderr}")
            result = self.kappamu(arguments)
            runs += 1
            different = self.difference(self.content(run), expected)
            if result.returncode not in DONE or different:
                self.fail(f"{name}, after kill {done}: exit code {result.returncode}, differs in {different}; "
                          f"{result.stderr}")
            else:
                equal += 1
        self.add(f"SIGKILL of run, {name}", f"{done} kills", f"{equal} of {runs} runs end in equal files",
                 time.time() - start)

    @staticmethod
    def clear(folder):
        shutil.rmtree(folder, ignore_errors=True)

    # 2. Flipped bits: one in each of many files, all of which verify names.

    def flips(self, count):
        start = time.time()
        whole = self.work / "whole"
        given = self.measurements() if self.options.quick else self.session()
        self.made(["run", str(given), "-o", str(whole), *NEW])
        files = [f for f in sorted(whole.rglob("*")) if f.is_file() and f.name not in ("run.lock", "run.json")]
        run = self.work / "flipped"
        done = noticed = harmless = 0
        while done < count:
            self.clear(run)
            shutil.copytree(whole, run)
            chosen = self.random.sample(files, min(len(files), max(1, count - done - 1)))
            for file in chosen:
                self.flip(run / file.relative_to(whole))
            seen = self.kappamu(["verify", str(run), "--json"])
            named = {f["name"] for f in json.loads(seen.stdout.splitlines()[-1])["findings"] if f["what"] == "changed"}
            for file in chosen:
                done += 1
                if str(file.relative_to(whole)) in named:
                    noticed += 1
                else:
                    self.fail(f"a flipped bit in {file.relative_to(whole)} is not noticed")
                shutil.copy2(file, run / file.relative_to(whole))
            # The record itself.
            self.flip(run / "run.json")
            done += 1
            seen = self.kappamu(["verify", str(run)])
            if seen.returncode != 0:
                noticed += 1
            elif json.loads((run / "run.json").read_text()) == json.loads((whole / "run.json").read_text()):
                harmless += 1
            else:
                self.fail("a flipped bit in run.json is not noticed")
        self.add(f"flipped bit in a run of {len(files) + 1} files", f"{done} bits",
                 f"{noticed} noticed, {harmless} without effect", time.time() - start)

    def flip(self, file):
        content = bytearray(file.read_bytes())
        if not content:
            return
        bit = self.random.randrange(8 * len(content))
        content[bit // 8] ^= 1 << bit % 8
        times = file.stat()
        file.write_bytes(content)
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))

    # 3. The n-th call fails.

    def faults(self):
        given = str(self.measurements())
        self.made(["run", given, "-o", str(self.work / "source"), *NEW])
        volume = self.work / "volume.vdb"
        shutil.copy2(self.work / "source" / "fit" / "volume.vdb", volume)
        run = lambda out, options: ["run", given, "-o", str(out), *options]
        export = lambda out: ["export", str(volume), "-o", str(out)]
        commands = {"export": (export, lambda out: self.made(export(out))),
                    "run": (lambda out: run(out, NEW), lambda out: self.made(run(out, OLD))),
                    "resume": (lambda out: run(out, NEW), lambda out: self.killed(run(out, NEW)))}
        for name in self.options.command or commands:
            self.faults_of(name, *commands[name])

    def killed(self, arguments):
        """Leaves a run in the middle of its fit."""
        child = subprocess.Popen([self.options.program, *arguments], env=self.environment,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        partial = Path(arguments[3]) / "fit.partial"
        while child.poll() is None and not list(partial.rglob("checkpoint*.bin")):
            time.sleep(0.002)
        child.kill()
        child.wait()

    def faults_of(self, name, arguments, before):
        folder = self.work / name
        self.clear(folder)
        folder.mkdir()
        # The output folder has one name throughout, since records and reports hold it.
        out = folder / "out"
        before(out)
        shutil.copytree(out, folder / "old")
        old = self.content(out)
        self.kappamu(arguments(out), count=folder / "counts")
        new = self.content(out)
        calls = {k: int(n) for k, n in (line.split() for line in (folder / "counts").read_text().splitlines())}
        for kind in self.options.kind or KINDS:
            start = time.time()
            most = self.options.mallocs if kind in ("malloc", "thread") else self.options.calls
            step = max(1, -(-calls[kind] // most))
            tally = {"done": 0, "refused": 0}
            sound = []
            tried = range(self.random.randint(1, step), calls[kind] + 1, step)
            with self.server(arguments(out)) as run:
                for n in tried:
                    self.clear(out)
                    shutil.copytree(folder / "old", out)
                    self.check_fault(f"{name} {kind}:{n}", run(f"{kind}:{n}"), arguments(out), out, old, new, tally,
                                     sound)
            self.add(f"{name}: {kind} fails", f"{len(tried)} of {calls[kind]} calls",
                     f"{tally['done']} done, {tally['refused']} refused in one sentence", time.time() - start)

    def check_fault(self, what, result, again, out, old, new, tally, sound):
        """Afterwards each file is an old or a new one, and the same command ends in the new ones. `sound`: folders
        known to end so."""
        lines = [line for line in result.stderr.splitlines() if not line.startswith("warning: ")]
        found = self.content(out)
        if result.returncode in DONE and not lines:
            tally["done"] += 1
            different = self.difference(found, new)
            # A checkpoint that cannot be read costs time, and the fit's record says so.
            told = "A checkpoint" in result.stderr and different == "fit/fit.json, run.json"
            if different and not told:
                self.fail(f"{what}: exit code {result.returncode}, but {different} differ")
            return
        if result.returncode != 1 or len(lines) != 1 or not lines[0].startswith("kappamu: "):
            self.fail(f"{what}: exit code {result.returncode}, {result.stderr[-400:]!r}")
            return
        tally["refused"] += 1
        # Records and what an interrupted attempt leaves apart.
        kept = [n for n in found if ".partial" not in n and n not in ("run.json", "kappamu-files.json")]
        mixed = [n for n in kept if found[n] not in (old.get(n), new.get(n))]
        lost = [n for n in old if n in new and ".partial" not in n and n not in found]
        if mixed or lost:
            self.fail(f"{what}: neither old nor new: {mixed[:5]}, lost: {lost[:5]}")
        if found in sound:
            return
        repeated = self.kappamu(again)
        different = self.difference(self.content(out), new)
        if repeated.returncode not in DONE or different:
            self.fail(f"{what}: repeated, exit code {repeated.returncode}, differs in {different}; "
                      f"{repeated.stderr[-300:]}")
        else:
            sound.append(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--library", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kills", type=int, default=200, help="of a run of measurements")
    parser.add_argument("--session-kills", type=int, default=200, help="of a run of photographs")
    parser.add_argument("--flips", type=int, default=1000)
    parser.add_argument("--calls", type=int, default=10000, help="of each kind at most about so many fail; 0: none")
    parser.add_argument("--mallocs", type=int, default=1000, help="the same for allocations")
    parser.add_argument("--quick", action="store_true", help="a minute's sample, without photographs")
    parser.add_argument("--command", action="append", choices=["export", "run", "resume"], help="calls of these only")
    parser.add_argument("--kind", action="append", choices=KINDS, help="calls of these kinds only")
    options = parser.parse_args()
    if options.quick:
        options.flips, options.kills, options.session_kills, options.calls, options.mallocs = 60, 6, 0, 2, 3
    trials = Trials(options)
    if options.flips:
        trials.flips(options.flips)
    if options.kills:
        trials.kills(options.kills, "of measurements", trials.measurements(), ["--device", "reference"])
    if options.session_kills:
        # The last digits of a calibration are not the same in every process (docs/limits.md).
        trials.kills(options.session_kills, "of calibrated photographs", trials.session(), NEW, "calibrate")
    if options.calls:
        trials.faults()
    print("\n| trial | tried | outcome | seconds |\n|---|---|---|---|")
    for row in trials.rows:
        print("| {} | {} | {} | {:.0f} |".format(*row))
    print(f"\ntrials: {len(trials.failures)} failures, seed {options.seed}")
    sys.exit(1 if trials.failures else 0)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Runs clang-tidy over the .cpp files of the tree, remembering which ones passed.

    scripts/lint_tidy.py [--build build-lint] [--jobs 2] [--tests] [FILE ...]

A verdict is kept under the hash of all that can change it: clang-tidy's version, .clang-tidy, the
compile command, the file, and our own headers it reaches. An unchanged file is not read again, so
a first pass costs minutes and the next ones seconds. Only passes are kept, in build-lint/lint-cache or
in the folder that KAPPAMU_LINT_CACHE names.
"""
import argparse
import concurrent.futures
import functools
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(rb'^\s*#\s*include\s*"([^"]+)"', re.M)
# clang does not know every warning of GCC that the compile commands name.
TIDY = ["clang-tidy", "--quiet", "--extra-arg=-Wno-unknown-warning-option"]


@functools.lru_cache(maxsize=None)
def reached(path):
    """`path` and the headers of ours that it includes itself: (hash of its text, headers)."""
    text = path.read_bytes()
    headers = []
    for name in INCLUDE.findall(text):
        for base in (ROOT, path.parent):
            header = base / name.decode()
            if header.is_file():
                headers.append(header)
                break
    return hashlib.sha256(text).hexdigest(), headers


def closure(path):
    """Name and hash of every file of ours that compiling `path` reads, in a fixed order."""
    seen, waiting = {}, [path]
    while waiting:
        file = waiting.pop()
        if file not in seen:
            seen[file], headers = reached(file)
            waiting += headers
    return sorted((os.path.relpath(file, ROOT), digest) for file, digest in seen.items())


def key(path, command, setting):
    """What the verdict on `path` depends on, wherever the tree lies."""
    words = [word.replace(str(ROOT), ".") for word in command]
    return hashlib.sha256(json.dumps([setting, words, closure(path)]).encode()).hexdigest()


def compile_commands(build):
    """The flags of every file that the build compiles: no compiler, launcher nor output name."""
    flags = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        if "-o" in words:
            words = words[: words.index("-o")]
        flags[pathlib.Path(entry["file"])] = [word for word in words if word.startswith("-")]
    return flags


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build-lint")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--tests", action="store_true", help="read tests/ too")
    parser.add_argument("files", nargs="*")
    options = parser.parse_args()

    listed = subprocess.run(["git", "ls-files", "*.cpp"], cwd=ROOT, check=True, capture_output=True, text=True)
    tree = [name for name in listed.stdout.split() if options.tests or not name.startswith("tests/")]
    files = [ROOT / name for name in options.files or tree]
    commands = compile_commands(options.build)
    absent = [file for file in files if file not in commands]
    if absent:
        # clang-tidy would guess a command from a neighbour, and fail on headers that are not found.
        print(f"lint: not compiled in {options.build}, left out: " +
              ", ".join(str(file.relative_to(ROOT)) for file in absent), flush=True)
        files = [file for file in files if file in commands]
    version = subprocess.run(["clang-tidy", "--version"], check=True, capture_output=True, text=True).stdout
    setting = [version, (ROOT / ".clang-tidy").read_text(), TIDY]
    cache = pathlib.Path(os.environ.get("KAPPAMU_LINT_CACHE", options.build / "lint-cache"))
    cache.mkdir(parents=True, exist_ok=True)

    def check(file):
        verdict = cache / key(file, commands[file], setting)
        if verdict.exists():
            return file, None, 0.0
        start = time.monotonic()
        run = subprocess.run([*TIDY, "-p", str(options.build), str(file)], capture_output=True, text=True)
        if run.returncode == 0:
            verdict.touch()
        return file, run, time.monotonic() - start

    read, bad = 0, 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for done in concurrent.futures.as_completed([pool.submit(check, file) for file in files]):
            file, run, seconds = done.result()
            if run is None:
                continue
            read += 1
            if run.returncode != 0:
                bad += 1
                print(run.stdout or run.stderr)
            print(f"lint: {file.relative_to(ROOT)} {seconds:.0f} s", flush=True)
    print(f"lint: {len(files)} sources, {read} read, {len(files) - read} unchanged, {bad} against .clang-tidy")
    return 1 if bad or not files else 0


if __name__ == "__main__":
    sys.exit(main())

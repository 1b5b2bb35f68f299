#!/usr/bin/python3
"""Measures what binds the sweeps of the finest grid on this processor: bytes, operations, instructions, cycles a red cell.

    studies/kernel_floor.py [--target haswell skylake-avx512] [--rounds 3]

The kernels' text is compiled by clang-15 (PoCL's compiler here) for each target and linked with studies/forward/kernel_floor.c.
One thread runs 256 x 256 x 20 cells of 16 patterns in single precision, in tiles of 256 cells. Two further programs read one
row of coefficients, or one row of everything, over and over: what they save is what memory costs. The programs run in turn;
each figure is the least of its rounds. Instructions are callgrind's (Valgrind), which knows AVX2 only. Prints Markdown.
"""
import argparse
import collections
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
KERNELS = ROOT / "forward/grid/opencl/kernels"
PRELUDES = [ROOT / "forward/linear/opencl/lanes_prelude.cl", KERNELS / "grid_prelude.cl", KERNELS / "grid_stencil_prelude.cl"]
FILES = {"cycle": [], "step": [], "reduced": [KERNELS / "grid_accurate_ring.cl"]}
NAMES = {"cycle": "grid_stream_cycle.cl", "step": "grid_stream_step.cl", "reduced": "grid_reduced.cl"}
# Bytes a red cell and pattern group: halves of vectors (64 bytes each) and coefficients (of two cells), as engine.md counts them.
BYTES = {"stream_down": 64 + 2 * 8 + 2 * 8 * 4, "stream_up": 2 * 64 + 2 * 8 + 2 * 8 * 4, "stream_step": 7 * 64 + 2 * 5 * 4,
         "reduced_residual": 6 * 64 + 2 * 4 * 4}
ONE_ROW = {"coefficients": {"STENCIL_ROW(y, z, parity)": "((parity) * HALF)"}}
ONE_ROW["everything"] = dict(ONE_ROW["coefficients"], **{"RED_ROW(y, z)": "((((z) + (y)) & 3) * HALF)",
                                                         "CELL(x, y, z)": "((((z) + (y)) & 3) * nx + (x))"})
BUILTINS = """
#define OF __attribute__((overloadable))
int OF min(int a, int b) { return a < b ? a : b; }
int OF max(int a, int b) { return a > b ? a : b; }
double16 OF convert_double16(float16 a) { return __builtin_convertvector(a, double16); }
float16 OF convert_float16(double16 a) { return __builtin_convertvector(a, float16); }
double16 OF convert_double16(double16 a) { return a; }
"""


def build(folder, target, one_row):
    """A program of the kernels for a target; the named indices lead to one row."""
    objects = []
    for part, more in FILES.items():
        stream = KERNELS / "grid_stream_prelude.cl"
        text = "".join(path.read_text() for path in [*PRELUDES, *more, stream, KERNELS / NAMES[part]])
        for macro, value in one_row.items():
            text, count = re.subn(r"#define " + re.escape(macro) + r" .*", f"#define {macro} {value}", text)
            if count != 1:
                sys.exit(f"kernel_floor: grid_stencil_prelude.cl defines {macro} {count} times")
        objects.append(compiled(folder, part, text, target))
    objects.append(compiled(folder, "builtins", BUILTINS, target))
    program = folder / "program"
    subprocess.run(["gcc", "-O2", ROOT / "studies/forward/kernel_floor.c", *objects, "-Wl,-z,muldefs", "-lm", "-o", program], check=True)
    return program


def compiled(folder, name, text, target):
    source, made = folder / (name + ".cl"), folder / (name + ".o")
    source.write_text(text)
    subprocess.run(["clang-15", "-x", "cl", "-cl-std=CL1.2", "-Xclang", "-finclude-default-header", "-target", "x86_64-linux-gnu",
                    f"-march={target}", "-O3", "-ffp-contract=fast", "-DWIDTH=16", "-w", "-c", source, "-o", made], check=True)
    return made


def run(program, repetitions, grid):
    words = [str(word) for word in (repetitions, *grid, grid[0])]
    return json.loads(subprocess.run([program, *words], check=True, capture_output=True, text=True).stdout)


def kind(name, arguments):
    """What an instruction is, and whether it loads a vector or number for one."""
    memory, vector = "(" in arguments, "mm" in arguments
    store = vector and name.startswith("vmov") and arguments.rstrip().endswith(")")
    load = vector and memory and not store
    if not vector:
        return "other", False
    if store:
        return "store", False
    if "broadcast" in name:
        return "broadcast", load
    for start, what in (("vf", "fma"), ("vmul", "multiply"), ("vadd", "add"), ("vsub", "add")):
        if name.startswith(start):
            return what, load
    return "move", load


def instructions(folder, program):
    """Executed instructions of each kernel by kind, and vector loads, from callgrind on a small grid."""
    grid, out = (64, 64, 20), folder / "callgrind"
    words = [str(word) for word in (1, *grid, grid[0])]
    subprocess.run(["valgrind", "--tool=callgrind", "--dump-instr=yes", f"--callgrind-out-file={out}", program, *words], check=True,
                   capture_output=True)
    cost, address, called = collections.Counter(), 0, False
    for line in out.read_text().splitlines():
        called_here = line.startswith("calls=")
        match = re.match(r"^(0x[0-9a-f]+|[+-]\d+|\*) \S+ (\d+)$", line)
        if match:
            place = match.group(1)
            address = int(place, 16) if place.startswith("0x") else address if place == "*" else address + int(place)
            if not called:
                cost[address] += int(match.group(2))
        called = called_here
    found, function = collections.defaultdict(collections.Counter), None
    listing = subprocess.run(["objdump", "-d", "--no-show-raw-insn", program], check=True, capture_output=True, text=True).stdout
    for line in listing.splitlines():
        match = re.match(r"^[0-9a-f]+ <(.*)>:", line)
        if match:
            function = match.group(1)
            continue
        match = re.match(r"^\s*([0-9a-f]+):\s+(\S+)\s*(.*)", line)
        if match and function in BYTES:
            what, load = kind(match.group(2), match.group(3))
            times = cost[int(match.group(1), 16)] or cost[int(match.group(1), 16) + 0x400000]
            found[function][what] += times
            found[function]["load"] += times if load else 0
    reds = grid[0] * grid[1] * grid[2] / 2
    return {name: {what: count / reds for what, count in kinds.items()} for name, kinds in found.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", nargs="+", default=["haswell", "skylake-avx512"])
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    grid = (256, 256, 20)
    reds = grid[0] * grid[1] * grid[2] / 2
    with tempfile.TemporaryDirectory() as name:
        programs, least = {}, {}
        for target in options.target:
            for what, one_row in {"all": {}, **ONE_ROW}.items():
                folder = pathlib.Path(name) / (target + what)
                folder.mkdir()
                programs[target, what] = build(folder, target, one_row)
        for _ in range(options.rounds):
            for key, program in programs.items():
                times = run(program, 3, grid)
                old = least.setdefault(key, times)
                least[key] = {k: (max if k == "clock_ghz" else min)(old[k], v) for k, v in times.items()}
        print("| kernel | target | bytes | cycles | coefficients in cache | all in cache |\n|---|---|---|---|---|---|")
        for kernel, size in BYTES.items():
            for target in options.target:
                cycles = [least[target, what][kernel] * 1e6 * least[target, what]["clock_ghz"] / reds for what in ("all", *ONE_ROW)]
                print(f"| `{kernel}` | {target} | {size} | " + " | ".join(f"{c:.0f}" for c in cycles) + " |")
        if "haswell" not in options.target:
            return
        print("\n| kernel | instructions | multiply, fma | add | vector loads | stores | other than vector |\n|---|---|---|---|---|---|---|")
        for kernel, kinds in instructions(pathlib.Path(name), programs["haswell", "all"]).items():
            total = sum(count for what, count in kinds.items() if what != "load")
            print(f"| `{kernel}` | {total:.0f} | {kinds['multiply'] + kinds['fma']:.0f} | {kinds['add']:.0f} | {kinds['load']:.0f} "
                  f"| {kinds['store']:.0f} | {kinds['other']:.0f} |")


if __name__ == "__main__":
    main()

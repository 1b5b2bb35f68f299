#!/usr/bin/env python3
"""Strong and weak scaling of one solve by kappamu-mpi, from constants measured on one machine (docs/distributed.md, "Beyond
this machine"). Prints the tables of that page."""
import argparse
import math

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
parser.add_argument("--voxel-seconds", type=float, required=True, help="processor seconds of a voxel and iteration")
parser.add_argument("--setup-seconds", type=float, required=True, help="processor seconds of a voxel and set-up")
parser.add_argument("--iterations", type=int, default=11, help="of a pattern, to 1e-6")
parser.add_argument("--exchanges", type=float, default=5.8, help="with each neighbour, of an iteration and level")
parser.add_argument("--reductions", type=float, default=3.1, help="of an iteration")
parser.add_argument("--halo", type=float, default=8.0, help="halos of the finest level sent in an iteration, all levels together")
parser.add_argument("--bytes", type=float, default=490.0, help="memory of a voxel with two patterns [bytes]")
parser.add_argument("--latency", type=float, default=2e-6, help="of a message [s]")
parser.add_argument("--bandwidth", type=float, default=2e9, help="of a rank [bytes/s]")
parser.add_argument("--neighbours", type=float, default=16.0, help="mean over the levels")
options = parser.parse_args()

# Levels of 64 x 64 x 64 voxels, and by how many a level is smaller than the one before (measured).
levels_there, voxels_there, coarsening = 8, 64**3, 3.8


def seconds(shape, ranks):
    """Of one pattern: work, messages, reductions; and of the set-up."""
    voxels = math.prod(shape)
    levels = levels_there + math.log(voxels / voxels_there, coarsening)
    side = math.sqrt(shape[0] * shape[1] / ranks)  # of a rank's rectangle across the light
    neighbours = 0 if ranks == 1 else min(options.neighbours, ranks - 1)
    halo = 0 if ranks == 1 else 4 * side * shape[2] * 8
    work = options.voxel_seconds * voxels / ranks
    messages = levels * options.exchanges * neighbours * options.latency + options.halo * halo / options.bandwidth
    reductions = options.reductions * math.log2(ranks) * options.latency
    return [options.iterations * t for t in (work, messages, reductions)] + [options.setup_seconds * voxels / ranks]


def table(title, rows):
    print(f"\n{title}\n\n| voxels | ranks | GB a rank | set-up s | work s | messages s | reductions s | s a pattern | efficiency |")
    print("|---|---|---|---|---|---|---|---|---|")
    first = before = None
    for shape, ranks in rows:
        work, messages, reductions, setup = seconds(shape, ranks)
        total = work + messages + reductions
        memory = options.bytes * math.prod(shape) / ranks / 1e9
        cost = total * ranks / math.prod(shape)
        if before is None or ranks < before:  # another block
            first = cost
        before = ranks
        print(f"| {' × '.join(map(str, shape))} | {ranks} | {memory:.2g} | {setup:.2g} | {work:.2g} | {messages:.2g} | "
              f"{reductions:.1g} | {total:.2g} | {100 * first / cost:.0f} % |")


many = (64, 256, 1024, 4096)
table("Strong scaling", [((1024, 1024, 1024), n) for n in many] + [((4096, 4096, 320), n) for n in many])
table("Weak scaling, 128 × 128 × 1024 voxels a rank",
      [((128 * 2**(k // 2), 128 * 2**(k - k // 2), 1024), 2**k) for k in (0, 2, 4, 6, 8, 10, 12)])

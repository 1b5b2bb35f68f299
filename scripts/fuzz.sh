#!/usr/bin/env bash
# Fuzzes the readers of everything that a stranger can hand in with libFuzzer under address and undefined-behaviour
# sanitizers: no crash, hang (30 s), leak (but for OpenVDB's) or allocation above 1.2 GiB: the largest
# picture of floats that readers allow (io/image/image_limits.h) takes 1.2 GB.
#   scripts/fuzz.sh TARGET|all [SECONDS [SEED]]     default 60 s each, any seed; without arguments lists the targets
# Begins with the good inputs that the program makes and with earlier findings (tests/fuzz/regression/TARGET); an input
# that fails stays in build-fuzz/crashes/TARGET.
set -euo pipefail
cd "$(dirname "$0")/.."
what=${1:-}
seconds=${2:-60}
seed=${3:-0}
command -v clang++ >/dev/null || { echo "fuzz: clang++ is missing; run scripts/setup.sh" >&2; exit 77; }
# Several tests may start this at once.
mkdir -p build-fuzz
exec 9>build-fuzz/lock
flock 9
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
cmake -S tests/fuzz -B build-fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++ >build-fuzz/log.txt 2>&1 &&
  cmake --build build-fuzz >>build-fuzz/log.txt 2>&1 ||
  { tail -n 30 build-fuzz/log.txt >&2; exit 1; }
flock -u 9
if [[ -z $what ]]; then exec build-fuzz/fuzz; fi
[[ $what == all ]] && targets=$(build-fuzz/fuzz) || targets=$what
# Files of a fuzzer live for a millisecond: in memory, where there is room.
[[ ! -w /dev/shm ]] || export TMPDIR=/dev/shm
status=0
for target in $targets; do
  export KAPPAMU_FUZZ=$target
  folders=("build-fuzz/corpus/$target" "build-fuzz/seeds/$target")
  mkdir -p "${folders[0]}" "build-fuzz/crashes/$target"
  # OpenVDB loses a node of 270 kB wherever a file ends within it: a search for leaks after each input would take all
  # the time, so that its target goes without, and in processes of so many inputs, with room for what is lost.
  leaks=1 most=-1
  [[ $target != vdb ]] || { leaks=0; most=30000; }
  # The system's libraries are not instrumented, so that their containers look overflown to the sanitizer.
  export ASAN_OPTIONS=detect_container_overflow=0:detect_leaks=$leaks
  KAPPAMU_FUZZ_SEEDS=${folders[1]} build-fuzz/fuzz
  [[ ! -d tests/fuzz/regression/$target ]] || folders+=("tests/fuzz/regression/$target")
  log=build-fuzz/$target.log
  found=0 runs=0 begun=$SECONDS piece=0
  while ((found == 0 && SECONDS - begun < seconds)); do
    build-fuzz/fuzz -seed="$((seed == 0 ? 0 : seed + piece))" -max_total_time="$((seconds - SECONDS + begun))" -runs=$most \
      -timeout=30 -rss_limit_mb=8192 -malloc_limit_mb=1229 -detect_leaks=$leaks \
      -max_len=65536 -print_final_stats=1 -verbosity=0 -close_fd_mask=2 -artifact_prefix="build-fuzz/crashes/$target/" \
      "${folders[@]}" >"$log" 2>&1 || found=1
    runs=$((runs + $(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | grep . || echo 0)))
    piece=$((piece + 1))
  done
  if [[ $found -eq 1 ]]; then
    tail -n 60 "$log" >&2
    status=1
  fi
  echo "| $target | $seconds s | $runs executions | $found findings |"
done
exit "$status"

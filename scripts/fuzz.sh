#!/usr/bin/env bash
# Fuzzes the readers of session.json and of photographs with libFuzzer under address and
# undefined-behaviour sanitizers: no crash, hang (30 s) or leak.
#   scripts/fuzz.sh session|image [SECONDS [SEED]]     default 60 s, any seed; crashing inputs stay in build-fuzz/
set -euo pipefail
cd "$(dirname "$0")/.."
what=${1:?session or image}
seconds=${2:-60}
seed=${3:-0}
command -v clang++ >/dev/null || { echo "fuzz: clang++ is missing; run scripts/setup.sh" >&2; exit 77; }
# Two tests may start this at once.
mkdir -p build-fuzz
exec 9>build-fuzz/lock
flock 9
cmake -S tests/fuzz -B build-fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++ >build-fuzz/log.txt 2>&1 &&
  cmake --build build-fuzz --target "${what}_fuzz" make_seeds >>build-fuzz/log.txt 2>&1 ||
  { tail -n 30 build-fuzz/log.txt >&2; exit 1; }
build-fuzz/make_seeds build-fuzz/seeds docs/formats.md
flock -u 9
mkdir -p "build-fuzz/corpus/$what" "build-fuzz/crashes-$what"
# The system's libraries are not instrumented, so that their containers look overflown to the sanitizer.
ASAN_OPTIONS=detect_container_overflow=0 "build-fuzz/${what}_fuzz" \
  -seed="$seed" -max_total_time="$seconds" -timeout=30 -rss_limit_mb=2048 -max_len=16384 -print_final_stats=1 -verbosity=0 -close_fd_mask=2 \
  -artifact_prefix="build-fuzz/crashes-$what/" "build-fuzz/corpus/$what" "build-fuzz/seeds/$what"
echo "fuzz: $what: nothing found in $seconds s"

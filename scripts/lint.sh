#!/usr/bin/env bash
# Checks the whole tree against .clang-format and .clang-tidy. `scripts/lint.sh --format` checks the
# format alone, `--prose` the length of the pages' sentences. clang-tidy reads the tests only when asked
# (`--tests`): GoogleTest's headers make them slow.
set -euo pipefail
cd "$(dirname "$0")/.."
[[ ${1:-} == --prose ]] && exec scripts/prose.py
mapfile -t sources < <(git ls-files '*.cpp' '*.h')
clang-format --dry-run --Werror "${sources[@]}"
echo "lint: ${#sources[@]} files obey .clang-format"
[[ ${1:-} == --format ]] && exit 0
# Every source by itself, without headers that GCC precompiled.
cmake -S . -B build-lint -G Ninja -DKAPPAMU_UNITY=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >lint.tmp 2>&1 ||
  { cat lint.tmp >&2; rm -f lint.tmp; exit 1; }
rm -f lint.tmp
exec scripts/lint_tidy.py --build build-lint "$@"

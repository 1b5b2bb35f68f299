#!/usr/bin/env bash
# Checks the whole tree against .clang-format and .clang-tidy. `scripts/lint.sh --format` checks the format alone.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t sources < <(git ls-files '*.cpp' '*.h')
clang-format --dry-run --Werror "${sources[@]}"
echo "lint: ${#sources[@]} files obey .clang-format"
[[ ${1:-} == --format ]] && exit 0
[[ -f build/compile_commands.json ]] || scripts/build.sh release
# GCC-only flags in the compile commands mean nothing to clang.
git ls-files '*.cpp' | grep -v '^tests/' |
  xargs -P "$(nproc)" -n 2 clang-tidy -p build --quiet --extra-arg=-Wno-unknown-warning-option 2>lint.tmp ||
  { rm -f lint.tmp; echo "lint: clang-tidy found the above" >&2; exit 1; }
rm -f lint.tmp
echo "lint: all sources obey .clang-tidy"

#!/usr/bin/env bash
# Tries the promises about files in docs/limits.md: SIGKILLs at random moments, flipped bits, and every n-th failing
# write, rename, sync, open and allocation. Prints a table of counts; fails unless there is no failure. Hours with the
# defaults, a minute with --quick; --help of tests/fault/trials.py lists the counts.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${KAPPAMU_PROGRAM:-$PWD/build/app/kappamu}
[[ -x $program ]] || { echo "trials: $program is missing; run scripts/build.sh release" >&2; exit 1; }
# In memory, where there is room: hundreds of runs are written.
work=$(mktemp -d -p "$([[ -w /dev/shm ]] && echo /dev/shm || echo "$PWD/build")" kappamu-trials-XXXXXX)
trap 'rm -rf "$work"' EXIT
gcc -O1 -Wall -Wextra -Werror -shared -fPIC -o "$work/fail_nth.so" tests/fault/fail_nth.c -ldl
python3 tests/fault/trials.py --program "$program" --library "$work/fail_nth.so" --work "$work" "$@"

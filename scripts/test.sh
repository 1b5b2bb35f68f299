#!/usr/bin/env bash
# Builds everything and passes all tests: dependencies, build, CTest. Arguments go to CTest: -R name, -L label, -LE slow
# to leave out the statistical ones.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release
echo "test: running CTest"
status=0
ctest --test-dir build --output-on-failure --no-tests=error -j2 --output-junit results.xml "$@" || status=$?
python3 scripts/test_summary.py build
exit "$status"

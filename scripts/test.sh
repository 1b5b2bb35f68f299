#!/usr/bin/env bash
# Builds everything and passes all tests: dependencies, build, CTest. Arguments go to CTest (-R name, -L label).
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release
echo "test: running CTest"
exec ctest --test-dir build --output-on-failure --no-tests=error -j2 "$@"

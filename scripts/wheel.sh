#!/usr/bin/env bash
# Makes a wheel of the Python package.
#   scripts/wheel.sh [FOLDER]      FOLDER: where it goes (default: dist). What build/ already has is not compiled again.
# The wheel runs where the Debian packages of scripts/setup.sh are: it holds kappamu's own code, not theirs.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-dist}
scripts/build.sh release kappamu_python >&2
rm -rf build/wheel-content
cmake --install build --component python --prefix build/wheel-content >/dev/null
/usr/bin/python3 scripts/make_wheel.py build/wheel-content/lib/python "$out"

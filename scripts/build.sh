#!/usr/bin/env bash
# Installs what is missing, configures and builds a preset (default: release).
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
scripts/setup.sh
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
echo "build: preset $preset"
start=$SECONDS
cmake --preset "$preset" >build-configure.tmp 2>&1 || { cat build-configure.tmp >&2; rm -f build-configure.tmp; exit 1; }
rm -f build-configure.tmp
cmake --build --preset "$preset"
echo "build: done in $((SECONDS - start)) s"

#!/usr/bin/env bash
# Installs what is missing, configures and builds a preset (default: release), or of it the targets named.
#   scripts/build.sh [PRESET [TARGET...]]
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true
scripts/setup.sh
# Precompiled headers are cached too.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
echo "build: preset $preset"
start=$SECONDS
cmake --preset "$preset" >build-configure.tmp 2>&1 || { cat build-configure.tmp >&2; rm -f build-configure.tmp; exit 1; }
rm -f build-configure.tmp
cmake --build --preset "$preset" ${1:+--target "$@"}
echo "build: done in $((SECONDS - start)) s"

#!/usr/bin/env bash
# Installs what BUILD holds into a scratch folder, builds the examples against it as a stranger's project would, and runs one.
#   install_test.sh BUILD SOURCE
set -euo pipefail
build=$1 source=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
cp -r "$source/examples" "$scratch/examples"
{ cmake -S "$scratch/examples" -B "$scratch/out" -DCMAKE_PREFIX_PATH="$scratch/prefix" -DCMAKE_BUILD_TYPE=Release &&
  cmake --build "$scratch/out"; } >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
"$scratch/out/slab" | tee "$scratch/slab"
grep -Eq 'exitance at the centre of z\+: 0\.[0-9]+ of' "$scratch/slab"

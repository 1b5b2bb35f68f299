#!/usr/bin/env bash
# Makes what follows from the descriptions of the commands: docs/reference/python-names.md and python/kappamu/commands.pyi.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh release kappamu_python >&2
export PYTHONPATH=build/python
/usr/bin/python3 -c 'from kappamu import stubs; print(stubs.table(), end="")' >python-names.tmp
mv python-names.tmp docs/reference/python-names.md
/usr/bin/python3 -c 'from kappamu import stubs; print(stubs.of_commands(), end="")' >python-names.tmp
mv python-names.tmp python/kappamu/commands.pyi

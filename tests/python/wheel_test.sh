#!/usr/bin/env bash
# The wheel of what is built, installed into a new environment, does what README says without the source tree.
#   wheel_test.sh BUILD SOURCE
set -euo pipefail
build=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --component python --prefix "$work/content" >/dev/null
wheel=$(/usr/bin/python3 "$source/scripts/make_wheel.py" "$work/content/lib/python" "$work/dist")
# NumPy is Debian's: nothing is fetched.
/usr/bin/python3 -m venv --system-site-packages "$work/venv"
"$work/venv/bin/pip" install --quiet --no-index --no-deps "$wheel"
cd "$work"
env -u PYTHONPATH "$work/venv/bin/python" - "$source/README.md" <<'PYTHON'
import pathlib
import re
import sys

import kappamu

assert "venv" in kappamu.__file__, kappamu.__file__
blocks = re.findall(r"^```python\n(.*?)^```$", pathlib.Path(sys.argv[1]).read_text(), re.M | re.S)
assert len(blocks) == 1
exec(blocks[0])
PYTHON
"$work/venv/bin/pip" check | grep -v "^No broken" | grep kappamu && exit 1
"$work/venv/bin/pip" uninstall --quiet --yes kappamu
echo "the wheel is installed, works and is removed again"

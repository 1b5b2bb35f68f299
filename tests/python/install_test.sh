#!/usr/bin/env bash
# README's lines that install the Python package and use it work as they stand: on a fresh copy of the tree, with an empty home
# and a plain environment, by the build tools that pip fetches. Needs PyPI and compiles everything, a quarter of an hour: CTest
# tests the same lines by the wheel of what is built (wheel_test.sh).
#   install_test.sh SOURCE
set -euo pipefail
source=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/tree" "$work/home" "$work/elsewhere"
git -C "$source" ls-files -z --cached --others --exclude-standard | tar -C "$source" --null -T - -c | tar -C "$work/tree" -x

# Of the caller's environment only what names its network and its compiler cache. The cache answers where paths and flags are
# those of scripts/build.sh.
clean=("HOME=$work/home" "PATH=/usr/sbin:/usr/bin:/sbin:/bin" LANG=C.UTF-8 "CCACHE_DIR=${CCACHE_DIR:-$HOME/.cache/ccache}"
  "CCACHE_BASEDIR=$work/tree" CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
  SKBUILD_CMAKE_DEFINE=KAPPAMU_WERROR=ON)
for name in PIP_CERT PIP_INDEX_URL PIP_FIND_LINKS SSL_CERT_FILE http_proxy https_proxy no_proxy; do
  [[ -z ${!name:-} ]] || clean+=("$name=${!name}")
done
plain() { env -i "${clean[@]}" "$@"; }

# block LANGUAGE WORD: README's block of code in that language that has the word.
block() {
  python3 - "$work/tree/README.md" "$1" "$2" <<'PYTHON'
import pathlib
import re
import sys

page, language, word = sys.argv[1:]
found = [b for b in re.findall(rf"^```{language}\n(.*?)^```$", pathlib.Path(page).read_text(), re.M | re.S) if word in b]
assert len(found) == 1, f"README has {len(found)} blocks of {language} with {word}"
print(found[0], end="")
PYTHON
}

# use PYTHON: README's Python, away from the tree, by the package of that environment.
use() {
  local printed
  printed=$(cd "$work/elsewhere" && block python "import" | plain "$1" -)
  echo "$printed"
  [[ $printed == *"kappa [mm]: 0."* ]]
  (cd "$work/elsewhere" && plain "$1" -c 'import kappamu, sys; assert kappamu.__file__.startswith(sys.prefix), kappamu.__file__')
}

start=$SECONDS
(cd "$work/tree" && block sh "pip install ." | plain bash -euo pipefail)
use "$work/tree/venv/bin/python"
plain "$work/tree/venv/bin/pip" check
echo "install_test: README's lines work; $((SECONDS - start)) s"

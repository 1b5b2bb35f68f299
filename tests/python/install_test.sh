#!/usr/bin/env bash
# README's lines that install the Python package and use it work as they stand: with an empty home and a plain environment, by the
# build tools that pip fetches from PyPI.
#   install_test.sh SOURCE         on a fresh copy of the tree; compiles everything, a quarter of an hour
#   install_test.sh SOURCE BUILD   in the tree itself, by what BUILD has compiled; SOURCE/venv and BUILD's set-up are lost
# The second is the last step of continuous integration; where PyPI cannot be reached it says so and ends well. CTest tests README's
# Python by the wheel of what is built (wheel_test.sh).
set -euo pipefail
source=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/home" "$work/elsewhere"

# Of the caller's environment only what names its network and its compiler cache.
clean=("HOME=$work/home" "PATH=/usr/sbin:/usr/bin:/sbin:/bin" LANG=C.UTF-8 "CCACHE_DIR=${CCACHE_DIR:-$HOME/.cache/ccache}"
  CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
  SKBUILD_CMAKE_DEFINE=KAPPAMU_WERROR=ON)
while IFS= read -r setting; do
  clean+=("$setting")
done < <(env | grep -iE '^(PIP_|SSL_CERT|REQUESTS_CA|CURL_CA|[a-z]+_proxy=)' || true)
plain() { env -i "${clean[@]}" "$@"; }
if [[ $# -gt 1 ]]; then
  plain python3 -m venv "$work/probe"
  if ! plain "$work/probe/bin/pip" download --quiet --no-deps --dest "$work" scikit-build-core; then
    echo "install_test: PyPI cannot be reached; README's pip lines were not tried"
    exit 0
  fi
  tree=$source
  clean+=("SKBUILD_BUILD_DIR=$(cd "$2" && pwd)" "CXX=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$2/CMakeCache.txt")")
  # pip's pybind11 in place of Debian's; without CXX pip's CMake takes Python's compiler and compiles everything anew.
  sed -i 's|^pybind11_DIR:PATH=.*|pybind11_DIR:PATH=pybind11_DIR-NOTFOUND|' "$2/CMakeCache.txt"
  rm -rf "$tree/venv"
else
  tree=$work/tree
  mkdir "$tree"
  git -C "$source" ls-files -z --cached --others --exclude-standard | tar -C "$source" --null -T - -c | tar -C "$tree" -x
fi
clean+=("CCACHE_BASEDIR=$tree")

# block LANGUAGE WORD: README's block of code in that language that has the word.
block() {
  python3 - "$tree/README.md" "$1" "$2" <<'PYTHON'
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
(cd "$tree" && block sh "pip install ." | plain bash -euo pipefail)
use "$tree/venv/bin/python"
plain "$tree/venv/bin/pip" check
echo "install_test: README's lines work; $((SECONDS - start)) s"

#!/usr/bin/env bash
# Installs what kappamu builds and tests with: Debian 12 packages, by name, nothing else. Quick when they are there.
#   scripts/setup.sh [--peers] [--distributed]     --peers: also the solver that `kappamu-studies` sets beside ours (hypre, MPI)
#                                                  --distributed: also what kappamu-mpi is built with (PETSc, MPI: 60 MB)
set -euo pipefail

build_packages=(
  g++ cmake ninja-build ccache git ca-certificates
  libeigen3-dev ocl-icd-opencl-dev opencl-headers pocl-opencl-icd
  libopencv-core-dev libopencv-imgproc-dev libopencv-calib3d-dev
  libopencv-features2d-dev libopencv-flann-dev libopencv-photo-dev libopencv-contrib-dev
  libceres-dev libopenimageio-dev libpng-dev libisal-dev libimath-dev libopenvdb-dev libtbb-dev libboost-iostreams-dev
  libraw-dev libmatio-dev libembree-dev libxxhash-dev
  libglfw3-dev libimgui-dev libepoxy-dev pkg-config libgl1-mesa-dri
  libcli11-dev nlohmann-json3-dev
  python3-dev python3-venv pybind11-dev
)
test_packages=(
  libgtest-dev libgmock-dev python3 python3-numpy python3-matplotlib python3-openvdb python3-vtk9 python3-jsonschema
  chromium xvfb xauth fonts-dejavu-core clang clang-format clang-tidy libclang-rt-14-dev
)
asked_packages=()
for option in "$@"; do
  case $option in
    --peers) asked_packages+=(libhypre-dev libopenmpi-dev openmpi-bin) ;;
    --distributed) asked_packages+=(libpetsc-real-dev libopenmpi-dev openmpi-bin) ;;
    *) echo "setup: unknown option $option; there are --peers and --distributed" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${build_packages[@]}" "${test_packages[@]}" "${asked_packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [[ $status == "install ok installed" ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "setup: all Debian packages are there"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || {
    echo "setup: run as root, or install sudo; missing packages: ${missing[*]}" >&2
    exit 1
  }
  as_root=(sudo)
fi
echo "setup: installing ${#missing[@]} Debian packages: ${missing[*]}"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${as_root[@]}" apt-get update &&
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "setup: apt-get failed; its last lines are above" >&2
  exit 1
fi
echo "setup: done"

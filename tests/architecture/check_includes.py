#!/usr/bin/env python3
"""Fails when an #include goes against the arrows of the house, or a heavy header leaks into one of ours.

    inverse -> forward -> device -> core     calib -> capture -> io -> core
    data_synthetic -> forward, capture, calib        app, bench, tests -> all
"""
import pathlib
import re
import sys
import tempfile

BELOW = {
    "core": set(),
    "device": {"core"},
    "forward": {"core", "device"},
    "inverse": {"core", "device", "forward"},
    "io": {"core"},
    "capture": {"core", "io"},
    "calib": {"core", "io", "capture"},
    "data_synthetic": {"core", "device", "io", "forward", "capture", "calib"},
}
TOP = {"app", "bench", "tests"}
# Libraries that must stay behind .cpp files, everywhere.
HEAVY = re.compile(r"^(opencv2|openvdb|ceres|nlohmann|CLI|OpenEXR|Imf)")
# The folders that build with -DKAPPAMU_PIPELINE=OFF may use nothing but these.
LIGHT_FOLDERS = {"core", "device", "forward", "inverse"}
LIGHT = re.compile(r"^(Eigen/|CL/|[a-z_0-9]+(\.h)?$|sys/)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def violations(root):
    """Sentences, one for each wrong include under root."""
    found = []
    for folder in sorted(set(BELOW) | TOP):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in {".h", ".cpp"}:
                continue
            name = path.relative_to(root)
            for kind, target in INCLUDE.findall(path.read_text()):
                first = target.split("/")[0]
                if kind == '"' and folder in BELOW:
                    if first not in BELOW[folder] | {folder}:
                        found.append(f"{name} includes {target}: {folder} may not use {first}")
                if kind == "<" and HEAVY.match(target) and path.suffix == ".h":
                    found.append(f"{name} includes <{target}>: keep it behind a .cpp file")
                if kind == "<" and folder in LIGHT_FOLDERS and not LIGHT.match(target):
                    found.append(f"{name} includes <{target}>: {folder} builds with Eigen and OpenCL alone")
    return found


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "core").mkdir()
        (root / "core" / "up.cpp").write_text('#include <vector>\n#include "inverse/fit.h"\n')
        (root / "io").mkdir()
        (root / "io" / "heavy.h").write_text("#include <openvdb/openvdb.h>\n")
        (root / "inverse").mkdir()
        (root / "inverse" / "good.cpp").write_text('#include <Eigen/Core>\n#include "forward/grid/grid_solver.h"\n')
        found = violations(root)
        assert len(found) == 2, found
        assert "core may not use inverse" in found[0] and "behind a .cpp" in found[1], found


def main():
    if sys.argv[1] == "--self-test":
        self_test()
        return 0
    found = violations(pathlib.Path(sys.argv[1]))
    print("\n".join(found) if found else "all includes follow the arrows")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Fails when an #include goes against the arrows of the house, or a heavy header leaks into one of ours.

    inverse -> forward -> device -> core     calib -> capture -> io -> core
    data_synthetic -> forward, capture, calib        render -> forward, io
    bench -> all but app        app, tests -> all
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
    "render": {"core", "device", "io", "forward"},
    "bench": {"core", "device", "io", "forward", "inverse", "capture", "calib", "data_synthetic", "render"},
}
TOP = {"app", "tests"}
# Libraries that must stay behind .cpp files: only a header that none but .cpp files of its own folder
# include may name them. A header of forward declarations costs its readers nothing.
HEAVY = re.compile(r"^(opencv2|openvdb|ceres|nlohmann|CLI|OpenEXR|Imf|libraw|exiv2|embree3|assimp)")
FORWARD_DECLARATIONS = {"nlohmann/json_fwd.hpp"}
# The folders that build with -DKAPPAMU_PIPELINE=OFF may use nothing but these: Eigen, OpenCL, the
# standard library and the system's C headers. Not even forward declarations of another library.
LIGHT_FOLDERS = {"core", "device", "forward", "inverse"}
LIGHT = re.compile(r"^(Eigen/|CL/|[a-z_0-9]+(\.h)?$|sys/)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def includes_of(root):
    """For every source under root, named from there: its includes as (kind, target)."""
    found = {}
    for folder in sorted(set(BELOW) | TOP):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in {".h", ".cpp"}:
                found[path.relative_to(root)] = INCLUDE.findall(path.read_text())
    return found


def readers_of(includes):
    """For every header of ours: the sources that include it, from the root or from beside it."""
    readers = {}
    for name, targets in includes.items():
        for _, target in targets:
            for header in {pathlib.PurePosixPath(target), name.parent / target}:
                readers.setdefault(str(header), []).append(name)
    return readers


def outsiders(header, readers):
    """Who includes `header` though it is no .cpp file of the header's own folder."""
    return [name for name in readers.get(str(header), [])
            if name.suffix != ".cpp" or name.parts[0] != header.parts[0]]


def violations(root):
    """Sentences, one for each wrong include under root."""
    found = []
    includes = includes_of(root)
    readers = readers_of(includes)
    for name, targets in includes.items():
        folder = name.parts[0]
        for kind, target in targets:
            first = target.split("/")[0]
            if kind == '"' and folder in BELOW:
                if first not in BELOW[folder] | {folder}:
                    found.append(f"{name} includes {target}: {folder} may not use {first}")
            if HEAVY.match(target) and target not in FORWARD_DECLARATIONS and name.suffix == ".h":
                for reader in outsiders(name, readers):
                    found.append(f"{name} includes {target} and {reader} includes {name}: "
                                 f"keep {target} behind the .cpp files of {folder}")
            if kind == "<" and folder in LIGHT_FOLDERS and not LIGHT.match(target):
                found.append(f"{name} includes <{target}>: {folder} builds with Eigen and OpenCL alone")
    return found


# A small tree per case: the files, and what the sentences about them hold (none: it is right).
CASES = {
    "an arrow upwards": (
        {"core/up.cpp": '#include <vector>\n#include "inverse/fit.h"\n'},
        ["core may not use inverse"]),
    "arrows downwards": (
        {"inverse/good.cpp": '#include <Eigen/Core>\n#include "forward/grid/grid_solver.h"\n'}, []),
    "a heavy header within its folder": (
        {"io/vdb.h": "#include <openvdb/openvdb.h>\n", "io/vdb.cpp": '#include "io/vdb.h"\n',
         "io/write.cpp": '#include "io/vdb.h"\n'}, []),
    "a heavy header through another header": (
        {"io/vdb.h": "#include <openvdb/openvdb.h>\n", "io/volume.h": '#include "io/vdb.h"\n'},
        ["io/volume.h includes io/vdb.h"]),
    "a heavy header through another header, from beside it": (
        {"io/vdb.h": "#include <openvdb/openvdb.h>\n", "io/volume.h": '#include "vdb.h"\n'},
        ["io/volume.h includes io/vdb.h", "io may not use vdb.h"]),
    "a heavy header from another folder": (
        {"io/vdb.h": "#include <openvdb/openvdb.h>\n", "capture/read.cpp": '#include "io/vdb.h"\n'},
        ["capture/read.cpp includes io/vdb.h"]),
    "forward declarations in a header": (
        {"io/json.h": "#include <nlohmann/json_fwd.hpp>\n", "capture/read.h": '#include "io/json.h"\n'}, []),
    "all of json in a header that travels": (
        {"io/json.h": "#include <nlohmann/json.hpp>\n", "capture/read.cpp": '#include "io/json.h"\n'},
        ["keep nlohmann/json.hpp behind the .cpp files of io"]),
    "forward declarations where the pipeline may be off": (
        {"forward/json.cpp": "#include <nlohmann/json_fwd.hpp>\n"},
        ["forward builds with Eigen and OpenCL alone"]),
}


def self_test():
    for case, (files, sentences) in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                (root / name).parent.mkdir(exist_ok=True)
                (root / name).write_text(text)
            found = violations(root)
        assert len(found) == len(sentences), (case, found)
        for sentence in sentences:
            assert any(sentence in line for line in found), (case, sentence, found)


def main():
    if sys.argv[1] == "--self-test":
        self_test()
        return 0
    found = violations(pathlib.Path(sys.argv[1]))
    print("\n".join(found) if found else "all includes follow the arrows")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

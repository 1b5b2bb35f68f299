#!/usr/bin/env python3
"""Fails when an #include goes against the arrows of the house, when the rooms of a folder include each other
in a circle, when a folder is crowded, or when a heavy header leaks into one of ours.

    inverse -> forward -> device -> core     calib -> capture -> io -> core     render -> forward, io
    data_synthetic -> forward, capture, calib        pipeline -> all of these but data_synthetic and render
    report -> pipeline's records        app, python -> all but studies       studies, tests -> all
    tests/cases -> inverse, forward: what tests and studies share in any build
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
    "pipeline": {"core", "device", "io", "forward", "inverse", "capture", "calib"},
    "report": {"core", "io", "forward", "inverse", "capture", "calib", "pipeline"},
    "render": {"core", "device", "io", "forward"},
    "tests/cases": {"core", "device", "forward", "inverse"},
    "studies": {"core", "device", "io", "forward", "inverse", "capture", "calib", "data_synthetic", "render", "pipeline", "app",
                "tests/cases"},
}
# Rooms of forward that some rooms may not look into: what two models share lies below both, in forward/linear or beside it.
APART = {
    "forward/polygrid": {"forward/embedded"},
    "forward/boundary_integral": {"forward/embedded", "forward/polygrid"},
    "forward/embedded": {"forward/polygrid", "forward/boundary_integral"},
    "forward/linear": {"forward/embedded", "forward/polygrid", "forward/boundary_integral", "forward/grid"},
}
# Of pipeline, the report reads the records that a run leaves, not the stages that make them.
RECORDS = "pipeline/records"
MOST_FILES = 25  # of its own in one folder; beyond, rooms by subject
TOP = {"app", "python", "tests"}
# Libraries that must stay behind .cpp files: only a header that none but .cpp files of its own folder
# include may name them. A header of forward declarations costs its readers nothing.
HEAVY = re.compile(r"^(opencv2|openvdb|ceres|nlohmann|CLI|OpenImageIO|libraw|embree3)")
FORWARD_DECLARATIONS = {"nlohmann/json_fwd.hpp"}
# The folders that build with -DKAPPAMU_PIPELINE=OFF may use nothing but these: Eigen, OpenCL, the
# standard library and the system's C headers. Not even forward declarations of another library.
LIGHT_FOLDERS = {"core", "device", "forward", "inverse", "tests/cases"}
LIGHT = re.compile(r"^(Eigen/|CL/|[a-z_0-9]+(\.h)?$|sys/)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)


def room_of(path):
    """The room of a source or an include: its folder, or a sub-folder that has arrows of its own."""
    room = "/".join(pathlib.PurePosixPath(path).parts[:2])
    return room if room in BELOW else room.split("/")[0]


def includes_of(root):
    """For every source under root, named from there: its includes as (kind, target)."""
    found = {}
    for folder in sorted(name for name in set(BELOW) | TOP if "/" not in name):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in {".h", ".cpp", ".cl"}:
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
        folder = room_of(name)
        for kind, target in targets:
            first = room_of(target)
            if kind == '"' and folder in BELOW:
                if first not in BELOW[folder] | {folder} and not first.startswith(folder + "/"):
                    found.append(f"{name} includes {target}: {folder} may not use {first}")
                if folder == "report" and first == "pipeline" and not target.startswith(RECORDS):
                    found.append(f"{name} includes {target}: report may use {RECORDS} alone")
            if HEAVY.match(target) and target not in FORWARD_DECLARATIONS and name.suffix == ".h":
                for reader in outsiders(name, readers):
                    found.append(f"{name} includes {target} and {reader} includes {name}: "
                                 f"keep {target} behind the .cpp files of {folder}")
            if kind == "<" and folder in LIGHT_FOLDERS and not LIGHT.match(target):
                found.append(f"{name} includes <{target}>: {folder} builds with Eigen and OpenCL alone")
    return found + apart(includes) + circles(includes) + crowded(includes)


def apart(includes):
    """Includes between rooms that may not look into each other."""
    return [f"{name} includes {target}: {room} may not use {other}"
            for name, targets in includes.items() for _, target in targets
            for room, others in APART.items() for other in sorted(others)
            if str(name).startswith(room + "/") and target.startswith(other + "/")]


def circles(includes):
    """Rooms of one folder that include each other in a circle. A room and the folder it lies in count as one:
    an interface stands above its implementations and the function that chooses one of them beside it."""
    arrows = {}
    for name, targets in includes.items():
        here = name.parent
        for _, target in targets:
            there = pathlib.PurePosixPath(target).parent
            if (here.parts[0] in BELOW and there.parts[:1] == here.parts[:1] and here not in there.parents
                    and there not in here.parents and here != there):
                arrows.setdefault(here, set()).add(there)

    def path(room, goal, seen):
        for other in sorted(arrows.get(room, ())):
            if other == goal:
                return [other]
            if other not in seen:
                rest = path(other, goal, seen | {other})
                if rest:
                    return [other, *rest]
        return []

    found = {}
    for room in sorted(arrows):
        circle = path(room, room, {room})
        if circle:
            found.setdefault(frozenset(circle), "rooms in a circle: " + " -> ".join(map(str, [room, *circle])))
    return list(found.values())


def crowded(includes):
    """Folders with more source files of their own than fit in a head."""
    count = {}
    for name in includes:
        count[name.parent] = count.get(name.parent, 0) + 1
    return [f"{folder}: {n} source files, at most {MOST_FILES}: rooms by subject"
            for folder, n in sorted(count.items()) if n > MOST_FILES]


# A small tree per case: the files, and what the sentences about them hold (none: it is right).
CASES = {
    "rooms in a circle": (
        {"inverse/a/x.h": '#include "inverse/b/y.h"\n', "inverse/b/y.h": '#include "inverse/c/z.h"\n',
         "inverse/c/z.cpp": '#include "inverse/a/x.h"\n'},
        ["rooms in a circle: inverse/a -> inverse/b -> inverse/c -> inverse/a"]),
    "an interface above its rooms": (
        {"forward/grid/solver.h": "", "forward/grid/choice.cpp": '#include "forward/grid/opencl/solver.h"\n',
         "forward/grid/opencl/solver.h": '#include "forward/grid/solver.h"\n'}, []),
    "a crowded folder": ({f"core/f{i}.h": "" for i in range(26)}, ["core: 26 source files"]),
    "a report that runs a stage": (
        {"report/page.cpp": '#include "pipeline/records/run.h"\n#include "pipeline/stages/fit.h"\n'},
        ["report/page.cpp includes pipeline/stages/fit.h"]),
    "an arrow upwards": (
        {"core/up.cpp": '#include <vector>\n#include "inverse/fit/fit.h"\n'},
        ["core may not use inverse"]),
    "an arrow from the cases to a study": (
        {"tests/cases/media.cpp": '#include "studies/record.h"\n'}, ["tests/cases may not use studies"]),
    "a study of a case": (
        {"studies/limits/size.cpp": '#include "tests/cases/media.h"\n'}, []),
    "a model that looks into another": (
        {"forward/polygrid/opencl/rows.h": '#include "forward/embedded/equations/levels.h"\n',
         "forward/polygrid/good.h": '#include "forward/linear/lanes.h"\n'},
        ["forward/polygrid/opencl/rows.h includes forward/embedded/equations/levels.h: forward/polygrid may not use"]),
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
                (root / name).parent.mkdir(exist_ok=True, parents=True)
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

#!/usr/bin/env python3
"""Fails when docs/architecture.md names a file that is not there, a function that its file does not hold, or a walk
through more than twelve files.

A name such as `solve()` or `ObjectProblem` behind a file's name, in the same step, is looked for in that file.
"""
import pathlib
import re
import sys

MOST_FILES = 12
NAME = re.compile(r"`([^`]+)`")


def faults(page, root):
    for section in re.split(r"^## ", page, flags=re.M)[1:]:
        title, _, text = section.partition("\n")
        files = set()
        for step in re.findall(r"^\d+\. .*$", text, flags=re.M):
            file = None
            for name in NAME.findall(step):
                if re.search(r"/.*\.(cpp|h|cl|inc)$", name):
                    file = root / name
                    files.add(name)
                    if not file.is_file():
                        yield f"{title}: there is no {name}"
                        file = None
                elif file and re.fullmatch(r"\w+\(\)", name) and name[:-2] not in file.read_text():
                    yield f"{title}: {file.relative_to(root)} holds no {name}"
        if len(files) > MOST_FILES:
            yield f"{title}: passes {len(files)} files, more than {MOST_FILES}"


root = pathlib.Path(sys.argv[1])
found = list(faults((root / "docs/architecture.md").read_text(), root))
if not list(faults("## w\n1. `a/b.cpp`\n", root)):
    found.append("a file that is not there is not found")
for fault in found:
    print(fault)
sys.exit(bool(found))

#!/usr/bin/env python3
"""Draws docs/images/architecture.svg from the includes of the tree: folders, their rooms, and who uses whom.

Needs Graphviz (Debian's graphviz). An arrow that others imply is left out: a -> c where a -> b -> c.
"""
import pathlib
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(root / "tests/architecture"))
from check_includes import BELOW, includes_of  # noqa: E402

SHOWN = [*BELOW, "app"]


def main():
    includes = includes_of(root)
    rooms, uses = {}, {}
    for name, targets in includes.items():
        top = name.parts[0]
        if top not in SHOWN:
            continue
        rooms.setdefault(top, set()).update(["/".join(name.parts[1:-1])] if len(name.parts) > 2 else [])
        for _, target in targets:
            there = target.split("/")[0]
            if there in SHOWN and there != top:
                uses.setdefault(top, set()).add(there)

    def reaches(start, goal):
        return any(n == goal or reaches(n, goal) for n in uses.get(start, ()))

    lines = ["digraph house {", "rankdir=BT; nodesep=0.25; ranksep=0.45; bgcolor=white;",
             'node [shape=box, style="rounded,filled", fillcolor="#f4f1ea", color="#8a8373", fontname="DejaVu Sans", fontsize=11];',
             'edge [color="#6b7f94", arrowsize=0.7];']
    for top in sorted(rooms):
        inner = "".join(f'<br/><font point-size="9" color="#555555">{room}</font>' for room in sorted(rooms[top]))
        lines.append(f'"{top}" [label=<<b>{top}</b>{inner}>];')
    for top in sorted(uses):
        for there in sorted(uses[top]):
            if not any(reaches(other, there) for other in uses[top] if other != there):
                lines.append(f'"{there}" -> "{top}" [dir=back];')
    lines.append("}")
    out = root / "docs/images/architecture.svg"
    subprocess.run(["dot", "-Tsvg", "-o", str(out)], input="\n".join(lines), text=True, check=True)
    print(out.relative_to(root))


if __name__ == "__main__":
    main()

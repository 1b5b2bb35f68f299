#!/usr/bin/env python3
"""Tables of the papers through the window: `kappamu view` by scripts, hidden, with its own clock.

  studies/window_tables.py KAPPAMU MESHES [table ...]

Tables: first (first picture and first light of every scene), wang (Table III of [W]), stroke, mertens3 and
mertens4 (Tables 3 and 4 of [M]); all by default. MESHES is a folder with spot, blub, bob, nefertiti and bunny as
.obj. Needs Xvfb, NumPy and Pillow. Prints the tables of docs/benchmarks.md, "Through the window". Times are medians. Those
by the clock want a machine that does nothing else, or real-time priority (`chrt -r 10`); the processor's times, of
all threads together, bear other work.
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

FRAMES = 15
# Table III of [W]: its model and frames a second without coherence; our mesh and the number of cells.
WANG = [("hole", 80.0, "spot", 62_000), ("snail", 53.4, "blub", 140_000), ("bust", 34.0, "bob", 557_000),
        ("bunny", 25.9, "nefertiti", 1_036_000), ("bird", 15.3, "bunny", 1_493_000)]
MATERIAL = {"kappa_mm": 0.3, "mu_per_mm": [0.003, 0.006, 0.009]}
SIZE_MM = 40
SUN = {"kind": "directional", "direction": [-0.3, -0.4, -0.85], "irradiance": 1}


def view(kappamu, folder, scene, lines, options=()):
    """What `view` reports of a script's lines; nothing where it refuses. `scene`: a file or its content."""
    if isinstance(scene, dict):
        (folder / "scene.json").write_text(json.dumps(scene))
        scene = folder / "scene.json"
    (folder / "script.txt").write_text("\n".join(["panel off", "trace off", *lines, "quit"]) + "\n")
    done = subprocess.run(["xvfb-run", "-a", kappamu, "--json", "view", scene, "--script", folder / "script.txt",
                           "-o", folder, *options], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(done.stderr.strip(), file=sys.stderr)
        return None
    return json.loads(done.stdout.strip().splitlines()[-1])


def scene_of(solid, light, size_mm, material, more=None):
    return {"format": "kappamu-scene", "version": 1,
            "objects": [{"name": "object", "size_mm": size_mm, "material": material, **solid, **(more or {})}],
            "lights": [light],
            "camera": {"position_mm": [0, 0, 6 * size_mm], "target_mm": [0, 0, 0], "fov_deg": 15},
            "film": {"width": 640, "height": 480, "samples": 1, "exposure": 2}}


def turning():
    return [f"light {20 + 2 * k} 25" for k in range(FRAMES)]


def first(kappamu, meshes, folder):
    print("| scene | first picture [s] | first light [s] | model |\n|---|---|---|---|")
    for scene in sorted((pathlib.Path(__file__).parents[1] / "scenes").glob("*.json")):
        if seen := view(kappamu, folder, scene, ["light 30 20"]):
            print(f"| {scene.stem} | {seen['first_picture_s']:.2f} | {seen['first_light_s']:.2f} | {seen['model']} |", flush=True)


def volume_of(mesh):
    """Of a closed mesh whose box's longest edge is 1."""
    corners, total = [], 0.0
    for words in map(str.split, mesh.read_text().splitlines()):
        if words[:1] == ["v"]:
            corners.append(np.array(words[1:4], float))
        if words[:1] == ["f"]:
            a, *rest = (corners[int(word.split("/")[0]) - 1] for word in words[1:])
            total += sum(a @ np.cross(b, c) / 6 for b, c in zip(rest, rest[1:]))
    return total / np.ptp(corners, axis=0).max() ** 3


def measured_object(folder, mesh, cells):
    """A scene of a volume with one voxel a cell, its eight octants unlike each other, and its voxels [mm]."""
    voxel = SIZE_MM * (volume_of(mesh) / cells) ** (1 / 3)
    edits = []
    for octant in range(8):
        far = [500 if octant >> axis & 1 else -500 for axis in range(3)]
        edits.append({"operation": "multiply", "kappa": 1 + 0.1 * octant, "mu": 1.5 - 0.1 * octant,
                      "where": {"kind": "box", "frame": "object", "from_mm": [min(0, x) for x in far],
                                "to_mm": [max(0, x) for x in far]}})
    (folder / "recipe.json").write_text(json.dumps({"format": "kappamu-edit", "version": 1, "voxel_mm": voxel, "edits": edits}))
    return scene_of({"mesh": str(mesh)}, SUN, SIZE_MM, MATERIAL, {"edits": "recipe.json"}), voxel


def polygrid(cells):
    return ["--model", "polygrid", "--parameter", f"first_cells={cells}"]


def wang(kappamu, meshes, folder):
    print("| of [W] | mesh | cells | memory [GB] | t1 light [ms] | t2 diffusion [ms] | t3 picture [ms] | frames a second | [W] | share | processor [ms] |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for model, paper, mesh, cells in WANG:
        scene, _ = measured_object(folder, meshes / f"{mesh}.obj", cells)
        seen = view(kappamu, folder, scene, turning(), polygrid(cells))
        fps = 1e3 / seen["picture_ms"]
        picture = seen["event_ms"] - seen["light_ms"] - seen["model_ms"]
        print(f"| {model} | {mesh} | {seen['elements']:,} | {seen['memory_bytes'] / 1e9:.1f} | {seen['light_ms']:.0f} | "
              f"{seen['model_ms']:.0f} | {picture:.0f} | {fps:.1f} | {paper} | {fps / paper:.2f} | {seen['picture_processor_ms']:.0f} |", flush=True)


def stroke(kappamu, meshes, folder):
    """10,000 voxels edited at 140,000 cells: a round brush of so many voxels, as deep as wide."""
    cells = 140_000
    scene, voxel = measured_object(folder, meshes / "spot.obj", cells)
    radius = voxel * (10_000 / (2 * math.pi)) ** (1 / 3)
    lines = [f"brush multiply mu 4 {radius} {2 * radius}"]
    lines += [f"paint {300 + 10 * (k % 5)} {190 + 10 * (k // 5)}" for k in range(FRAMES)]
    seen = view(kappamu, folder, scene, lines, polygrid(cells))
    print("| cells | brush [mm] | light [ms] | diffusion, with its equations [ms] | from the stroke to its picture [ms] | processor [ms] |")
    print("|---|---|---|---|---|---|")
    print(f"| {seen['elements']:,} | {radius:.2f} | {seen['light_ms']:.0f} | {seen['model_ms']:.0f} | {seen['event_ms']:.0f} | {seen['picture_processor_ms']:.0f} |")


def rod(file, around, high):
    """A closed rod of length 1 about z, 0.08 wide."""
    corners = [(0.04 * math.cos(2 * math.pi * k / around), 0.04 * math.sin(2 * math.pi * k / around), z / high - 0.5)
               for z in range(high + 1) for k in range(around)] + [(0, 0, -0.5), (0, 0, 0.5)]
    faces = []
    for k in range(around):
        after = (k + 1) % around
        for z in range(high):
            a, b, c, d = z * around + k, z * around + after, (z + 1) * around + after, (z + 1) * around + k
            faces += [(a, b, c), (a, c, d)]
        faces += [(after, k, len(corners) - 2), (high * around + k, high * around + after, len(corners) - 1)]
    file.write_text("".join("v {} {} {}\n".format(*p) for p in corners)
                    + "".join("f {} {} {}\n".format(*(i + 1 for i in f)) for f in faces))
    return {"mesh": str(file)}


def print_modes(kappamu, folder, rows):
    """[M]'s modes: a light that turns, a shape that moves with its links kept, and with all made anew."""
    print("| object | triangles | static [ms] | incremental [ms] | on the fly [ms] | frames a second | [M]: on the fly, incremental [ms] (triangles) | picture from scratch |")
    print("|---|---|---|---|---|---|---|---|")
    for name, scene, deformation, paper in rows:
        amount = "degrees" if "degrees" in deformation else "mm"
        for k in range(FRAMES + 1):
            share = 0.5 - 0.5 * math.cos(0.35 * k)
            shape = [{**deformation, amount: share * deformation[amount]}]
            (folder / f"{k}.json").write_text(json.dumps(shape))
        moving = [f"deform object {k}.json moving" for k in range(1, FRAMES + 1)]
        options = ["--model", "dipole-rotated"]
        static = view(kappamu, folder, scene, turning(), options)
        anew = view(kappamu, folder, scene, ["deform object 0.json moving", "links anew", *moving], options)
        kept = view(kappamu, folder, scene,
                    ["deform object 0.json moving", "links kept", *moving, f"deform object {FRAMES}.json", "screenshot kept.png"], options)
        at_once = {**scene, "objects": [{**scene["objects"][0], "deform": shape}]}
        view(kappamu, folder, at_once, ["screenshot scratch.png"], options)
        pictures = [np.asarray(Image.open(folder / f"{which}.png").convert("RGB"), float) for which in ("kept", "scratch")]
        for which in ("kept", "scratch"):
            (folder / f"{which}.png").unlink()
        off = np.linalg.norm(pictures[0] - pictures[1]) / np.linalg.norm(pictures[1])
        print(f"| {name} | {static['elements']:,} | {static['light_ms'] + static['model_ms']:.0f} | {kept['shape_ms']['incremental']:.0f} | "
              f"{anew['shape_ms']['on the fly']:.0f} | {1e3 / kept['event_ms']:.0f} | {paper} | {100 * off:.2f} % |", flush=True)


def mertens3(kappamu, meshes, folder):
    light = {"kind": "spot", "position_mm": [37, 50, 75], "target_mm": [0, 0, 0], "irradiance": 1, "at_mm": 100, "cone_deg": 60}
    bend = {"kind": "bend", "degrees": 100, "axis": [0, 0, 1]}
    print_modes(kappamu, folder, [
        ("rod bent", scene_of(rod(folder / f"rod{around}.obj", around, high), light, 25, {"published": "marble"}), bend, paper)
        for around, high, paper in ((16, 62, "20, 8 (2,016)"), (32, 125, "47, 23 (8,160)"), (64, 251, "188, 68 (32,736)"), (128, 505, "722, 351 (131,736)"))])


def mertens4(kappamu, meshes, folder):
    light = {"kind": "spot", "position_mm": [150, 200, 300], "target_mm": [0, 0, 0], "irradiance": 1, "at_mm": 400, "cone_deg": 60}
    dent = {"kind": "dent", "mm": -8, "brush": {"centre_mm": [0, 0, 50], "radius_mm": 30}}
    turn = {"kind": "twist", "degrees": 40, "axis": [0, 1, 0]}
    twist = {"kind": "twist", "degrees": 90, "axis": [0, 0, 1]}
    print_modes(kappamu, folder, [
        (name, scene_of(solid, light, 100, {"published": "marble"}), deformation, paper) for name, solid, deformation, paper in (
            ("spot (horse)", {"mesh": str(meshes / "spot.obj")}, turn, "97, – (8,764)"),
            ("nefertiti (bust)", {"mesh": str(meshes / "nefertiti.obj")}, turn, "102, – (10,518)"),
            ("blub (elk)", {"mesh": str(meshes / "blub.obj")}, turn, "165, – (11,384)"),
            ("candle", {"shape": "candle", "proportion": 0.42}, twist, "41, – (4,474)"),
            ("cube with a bump", {"shape": "cube"}, dent, "154, – (16,380)"))])


def main():
    kappamu, meshes = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    tables = {"first": first, "wang": wang, "stroke": stroke, "mertens3": mertens3, "mertens4": mertens4}
    for name in sys.argv[3:] or tables:
        print(f"load {os.getloadavg()[0]:.1f} before {name}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            tables[name](kappamu, meshes, pathlib.Path(folder))


if __name__ == "__main__":
    main()

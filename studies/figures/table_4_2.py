#!/usr/bin/env python3
"""[T] table 4.2: seconds of the embedded boundary's multigrid by material and scale, as a table of Markdown.

    studies/figures/table_4_2.py [build/app/kappamu] [--dragon dragon.obj]

The thesis's dragon is not shipped: the bust stands for it, and bob for its Venus, unless a dragon is given. One point light, red,
green and blue, tolerance 1 %; a mix is Perlin's marble of densities 1 to 10. Seconds are of the processor, the whole command.
"""
import argparse
import json
import pathlib
import resource
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATTERN = {"kind": "marble", "turbulence": 1.6, "seed": 5}


def mix(name, size):
    densities = [{"published": name, "density": density} for density in (0.316, 3.16)]
    return {"mix": densities, "pattern": {**PATTERN, "size_mm": size / 4}}


ROWS = [("milk mix", "dragon", 20, 63), ("milk mix", "dragon", 10, 105), ("marble", "dragon", 20, 215), ("marble", "dragon", 10, 296),
        ("marble", "dragon", 5, 445), ("marble mix", "venus", 100, 86), ("marble mix", "venus", 20, 206)]


def measure(program, mesh, material, size, folder):
    scene = {"format": "kappamu-scene", "version": 1,
             "objects": [{"name": "body", "mesh": str(mesh), "size_mm": size, "material": material}],
             "lights": [{"kind": "point", "position_mm": [0, 3 * size, size], "irradiance": 1, "at_mm": 3 * size}],
             "camera": {"position_mm": [0, 0, 4 * size], "target_mm": [0, 0, 0], "fov_deg": 20},
             "film": {"width": 16, "height": 16, "samples": 1}, "model": {"name": "embedded", "tolerance": 0.01}}
    file = folder / "scene.json"
    file.write_text(json.dumps(scene))
    out = folder / "out"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "render", file, "-o", out], check=False, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    channels = json.loads((out / "summary.json").read_text())["objects"][0]["channels"]
    subprocess.run(["rm", "-r", out, file], check=True)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, channels


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("program", nargs="?", default=ROOT / "build/app/kappamu")
    arguments.add_argument("--dragon", type=pathlib.Path, default=ROOT / "scenes/meshes/nefertiti.ply")
    options = arguments.parse_args()
    meshes = {"dragon": options.dragon.resolve(), "venus": ROOT / "scenes/meshes/bob.ply"}
    print("| material | model in [T], here | longest edge | [T] | here, three channels | cubes | cycles | stated error of numerics |\n"
          "|---|---|---|---|---|---|---|---|")
    for material, model, size, theirs in ROWS:
        of = mix({"milk mix": "whole milk", "marble mix": "marble"}[material], size) if "mix" in material else {"published": material}
        with tempfile.TemporaryDirectory() as folder:
            seconds, channels = measure(options.program, meshes[model], of, size, pathlib.Path(folder))
        print(f"| {material} | {model}, {meshes[model].stem} | {size} mm | {theirs} s | {seconds:.1f} s | "
              f"{max(c['elements'] for c in channels):,} | {max(c['iterations'] for c in channels)} | "
              f"{100 * max(c['error_estimate'] for c in channels):.1f} % |", flush=True)


if __name__ == "__main__":
    main()

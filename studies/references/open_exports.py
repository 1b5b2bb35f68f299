#!/usr/bin/env python3
"""Opens what `kappamu export` writes in the programs it is written for, and compares what they read.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 vtk==9.7.2 bpy==5.0.1 numpy
    venv/bin/python studies/references/open_exports.py --kappamu build/app/kappamu -o out/exports

A block of 24 x 20 x 8 voxels of 0.5 mm with an inclusion that absorbs (more in blue) is written as
NumPy arrays, exported, and opened by VTK's reader (ParaView's), by Mitsuba (scene.xml as it stands,
every value of its two grids), by NanoVDB's converter (Debian's libnanovdb-tools, to NanoVDB and
back, every value of density) and by Blender (Cycles on a Principled Volume that takes density and
color by their names). The text for pbrt, which no package has, is parsed here. Prints a line per program and ends with an error where one disagrees.
"""
import argparse
import json
import pathlib
import re
import subprocess
import time

import numpy as np

SHAPE = (8, 20, 24)  # [z][y][x]
EDGE = 0.5  # mm
PIXELS = (96, 80)  # of Blender's picture


def coefficients():
    """kappa [mm] and mu [1/mm] by channel, float32 [z][y][x]."""
    z, y, x = np.meshgrid(*(np.arange(n) + 0.5 for n in SHAPE), indexing="ij")
    inside = (x - 8) ** 2 + (y - 10) ** 2 + (2 * (z - 4)) ** 2 < 16
    slope = 1 + 0.002 * x + 0.003 * y + 0.004 * z  # no two axes alike
    return {channel: ((0.3 * slope).astype(np.float32),
                      np.where(inside, strength, 0.005).astype(np.float32))
            for channel, strength in zip("RGB", (0.1, 0.3, 0.8))}


def scattering(volume):
    """sigma_t [1/mm] and albedo, [z][y][x][channel]."""
    sigma_t = np.stack([1 / (3 * kappa) for kappa, _ in volume.values()], -1)
    return sigma_t, np.stack([1 - 3 * kappa * mu for kappa, mu in volume.values()], -1)


def export(kappamu, folder):
    arrays = folder / "arrays"
    arrays.mkdir(parents=True, exist_ok=True)
    units = {}
    for channel, (kappa, mu) in coefficients().items():
        for name, unit, values in (("kappa", "mm", kappa), ("mu", "1/mm", mu)):
            np.save(arrays / f"{name}_{channel}.npy", values)
            units[f"{name}_{channel}"] = unit
    (arrays / "volume.json").write_text(json.dumps(
        {"format": "kappamu-volume", "version": 1, "grid": SHAPE[::-1], "voxel_mm": EDGE,
         "channels": ["R", "G", "B"], "units": units, "eta": 1.3}), encoding="utf-8")
    subprocess.run([kappamu, "export", arrays, "-o", folder / "exported"], check=True,
                   stdout=subprocess.DEVNULL)
    return folder / "exported"


def largest_error(found, expected):
    return float(np.max(np.abs(np.asarray(found) / expected - 1)))


def vtk(folder, volume):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(folder / "volume.vti"))
    reader.Update()
    image = reader.GetOutput()
    assert image.GetDimensions() == tuple(n + 1 for n in SHAPE[::-1]), image.GetDimensions()
    assert image.GetSpacing() == (EDGE, EDGE, EDGE), image.GetSpacing()
    worst = 0.0
    for channel, pair in volume.items():
        for name, expected in zip(("kappa", "mu"), pair):
            values = vtk_to_numpy(image.GetCellData().GetArray(f"{name}_{channel}"))
            worst = max(worst, largest_error(values.reshape(SHAPE), expected))
    assert worst == 0.0, worst
    return f"{image.GetCellData().GetNumberOfArrays()} cell arrays, kappa and mu bit by bit"


def mitsuba(folder, volume):
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    worst = 0.0
    for name, expected in zip(("sigma_t", "albedo"), scattering(volume)):
        grid = mi.VolumeGrid(str(folder / "mitsuba" / f"{name}.vol"))
        worst = max(worst, largest_error(np.array(grid), expected))
    assert worst < 1e-6, worst
    begin = time.process_time()
    picture = np.array(mi.render(mi.load_file(str(folder / "mitsuba" / "scene.xml"))))
    seconds = time.process_time() - begin
    mi.util.write_bitmap(str(folder / "mitsuba.png"), picture)
    # Seen from z+ with y down, x grows to the left: the inclusion, in the block's first third, lies
    # right of the middle, and beside it is none.
    height, width = picture.shape[:2]
    row = picture[height // 2 - 4:height // 2 + 4].mean(axis=0)
    third = int(round(width / 1.33 / 3))  # of the block's columns in the film (scene.xml)
    left, right = (width - third) // 2, (width + third) // 2
    shadow = row[right - 5:right + 5].mean(axis=0) / row[left - 5:left + 5].mean(axis=0)
    assert shadow[0] > shadow[2] and shadow[2] < 0.8, shadow
    return (f"grids within {worst:.0e}; scene.xml in {seconds:.0f} s of processor time, light "
            f"through the inclusion over that beside it R {shadow[0]:.2f} G {shadow[1]:.2f} "
            f"B {shadow[2]:.2f}")


def pbrt(folder, volume):
    text = (folder / "medium.pbrt").read_text(encoding="utf-8")
    found = {name: numbers.split() for name, numbers in re.findall(r'"\S+ (\w+)" \[([^]]*)\]', text)}
    size = [int(re.search(rf'"integer n{axis}" (\d+)', text)[1]) for axis in "zyx"]
    assert tuple(size) == SHAPE and [float(x) for x in found["p1"]] == [n * EDGE for n in SHAPE[::-1]]
    sigma_a = np.stack([mu.astype(float) for _, mu in volume.values()], -1)
    sigma_s = np.stack([1 / (3 * kappa.astype(float)) for kappa, _ in volume.values()], -1) - sigma_a
    worst = max(largest_error(np.array(found[name], float).reshape(*SHAPE, 3), expected)
                for name, expected in (("sigma_a", sigma_a), ("sigma_s", sigma_s)))
    assert worst < 1e-6, worst
    return f"sigma_a and sigma_s of the rgbgrid within {worst:.0e}, parsed here"


def nanovdb(folder, volume):
    files = [str(folder.parent / name) for name in ("density.nvdb", "density.vdb")]
    subprocess.run(["nanovdb_convert", "-f", "-g", "density", folder / "volume.vdb", files[0]], check=True)
    report = subprocess.run(["nanovdb_validate", "-v", files[0]], check=True, capture_output=True, text=True)
    assert "passed" in report.stdout and "failed" not in report.stdout, report.stdout
    subprocess.run(["nanovdb_convert", "-f", files[0], files[1]], check=True)
    read = ("import sys, numpy, pyopenvdb as v; g = v.read(sys.argv[1], 'density');"
            "a = numpy.zeros([int(n) for n in sys.argv[3:]], numpy.float32); g.copyToArray(a); numpy.save(sys.argv[2], a)")
    array = str(folder.parent / "density.npy")
    # Debian's Python has pyopenvdb.
    subprocess.run(["/usr/bin/python3", "-c", read, files[1], array, *map(str, SHAPE[::-1])], check=True)
    expected = scattering(volume)[0].mean(axis=-1)
    worst = largest_error(np.load(array).transpose(2, 1, 0), expected)
    assert worst < 1e-6, worst
    return f"density within {worst:.0e} after NanoVDB and back, validated"


def blender(folder, _):
    import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.object.volume_import(filepath=str((folder / "volume.vdb").resolve()))
    block = bpy.context.object
    grids = block.data.grids
    grids.load()
    kinds = {grid.name: grid.data_type for grid in grids}
    assert kinds["density"] == "FLOAT" and kinds["color"] == "VECTOR_FLOAT", kinds
    assert kinds["sigma_t"] == "VECTOR_FLOAT", kinds
    material = bpy.data.materials.new("volume")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    shader.inputs["Density"].default_value = 1.0
    shader.inputs["Density Attribute"].default_value = "density"
    shader.inputs["Color Attribute"].default_value = "color"
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs["Volume"], output.inputs["Volume"])
    block.data.materials.append(material)
    size = [n * EDGE for n in SHAPE[::-1]]
    # Blender imports OpenVDB with its axes as they are; the light lies behind z-, as in scene.xml.
    bpy.ops.object.light_add(type="AREA", location=(size[0] / 2, size[1] / 2, -1),
                             rotation=(np.pi, 0, 0))
    lamp = bpy.context.object.data
    lamp.shape, lamp.size, lamp.size_y, lamp.energy = "RECTANGLE", 0.9 * size[0], 0.9 * size[1], 5e3
    bpy.ops.object.camera_add(location=(size[0] / 2, size[1] / 2, 40))
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("black")  # without a world Cycles lights no volume
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    scene.camera = bpy.context.object
    scene.camera.data.type = "ORTHO"
    scene.camera.data.ortho_scale = size[0]
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 16
    scene.cycles.volume_bounces = 64
    scene.cycles.max_bounces = 64
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = PIXELS
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str((folder / "blender.exr").resolve())
    begin = time.process_time()
    bpy.ops.render.render(write_still=True)
    seconds = time.process_time() - begin
    image = bpy.data.images.load(scene.render.filepath)
    picture = np.array(image.pixels[:]).reshape(PIXELS[1], PIXELS[0], 4)[..., :3]
    row = picture[PIXELS[1] // 2 - 6:PIXELS[1] // 2 + 6].mean(axis=0)
    third = PIXELS[0] // 3
    shadow = row[third - 5:third + 5].mean(axis=0) / row[2 * third - 5:2 * third + 5].mean(axis=0)
    assert shadow[0] > shadow[2] and shadow[2] < 0.8, shadow
    return (f"{bpy.app.version_string}: {len(kinds)} grids; Cycles in {seconds:.0f} s, light "
            f"through the inclusion over that beside it R {shadow[0]:.2f} G {shadow[1]:.2f} "
            f"B {shadow[2]:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--kappamu", default="kappamu")
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True)
    parser.add_argument("--programs", nargs="+", default=["vtk", "mitsuba", "pbrt", "nanovdb", "blender"])
    arguments = parser.parse_args()
    folder = export(arguments.kappamu, arguments.out)
    for program in arguments.programs:
        print(f"{program}: {globals()[program](folder, coefficients())}", flush=True)


if __name__ == "__main__":
    main()

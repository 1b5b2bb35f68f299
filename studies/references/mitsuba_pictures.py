#!/usr/bin/env python3
"""Pictures of `kappamu render` beside Mitsuba 3's of the same scenes: docs/gallery.md, "Beside Mitsuba".

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python studies/references/mitsuba_pictures.py build/app/kappamu -o out/mitsuba

Bob (scenes/meshes) of 20 mm under a sky with one wide lamp behind him: of one material, and of a volume of 24 x 36 x 36 voxels.
The surface is smooth, eta 1.3. The phase function is isotropic. Extinction is the same in R, G and B, so that Mitsuba's `volpath`
needs no weights by channel; colour is that of absorption. The light is a sky, since a smooth surface hides every smaller one from
path tracing. Written are plate.png (a row per scene: Mitsuba, each model of ours, its difference to Mitsuba in luminance by
blocks, full colour at 30 %) and plate.json. Compared are blocks of 8 x 8 pixels that the body covers. With a recent LLVM, `--variant llvm_ad_rgb` is as good.
"""
import argparse
import json
import pathlib
import subprocess
import time

import mitsuba as mi
import numpy as np

ETA, SIZE, TURN = 1.3, 20.0, 30.0  # mm, degrees about y
CAMERA = {"position_mm": [9, 26, 60], "target_mm": [0, -0.6, 0], "fov_deg": 15}
WIDTH, HEIGHT, BLOCK = 240, 192, 8
SKY = (128, 256)  # rows, columns
FULL = 0.3  # of differences
SHAPE = (36, 36, 24)  # voxels [z][y][x]
MESH = pathlib.Path(__file__).resolve().parents[2] / "scenes/meshes/bob.ply"


def material(voxels):
    """sigma_t [1/mm] and albedo of R, G, B: numbers, or arrays [z][y][x]."""
    if not voxels:
        absorption = np.array([0.004, 0.02, 0.09])
        return 1.3, 1.0 - absorption / 1.3
    z, y, x = ((index + 0.5) / count - 0.5 for index, count in zip(np.indices(SHAPE), SHAPE))
    wave = 0.5 + 0.5 * np.sin(14.0 * (0.6 * z + y) + 3.0 * np.sin(7.0 * x + 4.0 * z))
    extinction = 0.9 + 1.1 * wave
    absorption = np.stack([low + (high - low) * wave ** 3 for low, high in ((0.004, 0.02), (0.012, 0.5), (0.03, 0.9))], axis=-1)
    return extinction, 1.0 - absorption / extinction[..., None]


def sky():
    """[row][column][colour] as kappamu lays it: the top row is +y, the centre -z."""
    rows, columns = SKY
    theta = np.pi * (np.arange(rows) + 0.5) / rows
    phi = 2.0 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5)
    direction = np.stack([np.sin(theta)[:, None] * np.sin(phi), np.cos(theta)[:, None] * np.ones(columns),
                          -np.sin(theta)[:, None] * np.cos(phi)], axis=-1)
    lamp = np.array([0.5, 0.45, -0.74])
    image = np.full((rows, columns, 3), 0.06, np.float32)
    image[direction @ (lamp / np.linalg.norm(lamp)) > np.cos(np.radians(35.0))] = [2.2, 2.1, 1.9]
    return image


def corners():
    """Of the mesh file's bounding box."""
    box = mi.load_dict({"type": "ply", "filename": str(MESH)}).bbox()
    return np.array(box.min).ravel(), np.array(box.max).ravel()


def mitsuba_scene(voxels):
    low, high = corners()
    t = mi.ScalarTransform4f
    scale = float(SIZE / (high - low).max())
    placed = t().rotate([0, 1, 0], TURN) @ t().scale(scale) @ t().translate((-0.5 * (low + high)).tolist())
    extinction, albedo = material(voxels)
    if voxels:
        box = t().rotate([0, 1, 0], TURN) @ t().scale((scale * (high - low)).tolist()) @ t().translate([-0.5, -0.5, -0.5])
        grid = lambda values: {"type": "gridvolume", "grid": mi.VolumeGrid(np.ascontiguousarray(values, np.float32)),
                               "filter_type": "nearest", "wrap_mode": "clamp", "raw": True, "to_world": box}
        medium = {"type": "heterogeneous", "sigma_t": grid(extinction[..., None]), "albedo": grid(albedo), "scale": 1.0}
    else:
        medium = {"type": "homogeneous", "sigma_t": extinction, "albedo": {"type": "rgb", "value": albedo.tolist()}}
    image = np.roll(sky(), SKY[1] // 2, axis=1)  # Mitsuba's first column is -z
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 4096, "rr_depth": 64, "hide_emitters": True},
        "body": {"type": "ply", "filename": str(MESH), "to_world": placed, "face_normals": False,
                 "bsdf": {"type": "dielectric", "int_ior": ETA, "ext_ior": 1.0}, "interior": medium},
        "sky": {"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(image))},
        "sensor": {"type": "perspective", "fov": CAMERA["fov_deg"], "fov_axis": "y",
                   "to_world": t().look_at(origin=CAMERA["position_mm"], target=CAMERA["target_mm"], up=[0, 1, 0]),
                   "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}},
                   "sampler": {"type": "independent"}}})


def our_picture(program, folder, voxels, model, tolerance):
    """Radiance [y][x][4] of `kappamu render`, and its processor time as the clock has it."""
    extinction, albedo = material(voxels)
    absorption = (1.0 - albedo) * (extinction[..., None] if voxels else extinction)
    if voxels:
        volume = folder / "volume"
        volume.mkdir(exist_ok=True)
        units = {}
        for c, name in enumerate("RGB"):
            np.save(volume / f"kappa_{name}.npy", (1.0 / (3.0 * extinction)).astype(np.float32))
            np.save(volume / f"mu_{name}.npy", np.ascontiguousarray(absorption[..., c], np.float32))
            units |= {f"kappa_{name}": "mm", f"mu_{name}": "1/mm"}
        (volume / "volume.json").write_text(json.dumps({
            "format": "kappamu-volume", "version": 1, "grid": list(SHAPE[::-1]), "voxel_mm": 1.0, "channels": ["R", "G", "B"], "units": units}))
        own = {"volume": "volume", "placement": "stretch"}
    else:
        own = {"reduced_scattering_per_mm": (extinction - absorption).tolist(), "absorption_per_mm": absorption.tolist()}
    mi.Bitmap(sky()).write(str(folder / "sky.exr"))
    scene = folder / f"{'volume' if voxels else 'one'}-{model}.json"
    scene.write_text(json.dumps({
        "format": "kappamu-scene", "version": 1,
        "objects": [{"name": "bob", "mesh": str(MESH), "size_mm": SIZE, "turn_deg": [0, TURN, 0], "material": own,
                     "surface": {"eta": ETA, "roughness": 0}}],
        "lights": [{"kind": "environment", "image": "sky.exr", "radiance": 1, "visible": False}],
        "camera": CAMERA, "film": {"width": WIDTH, "height": HEIGHT, "samples": 64}, "model": {"name": model, "tolerance": tolerance, "follow_reentry": True}}))
    out = scene.with_suffix("")
    if not out.exists():
        subprocess.run([program, "render", str(scene), "-o", str(out)], check=True)
    return np.array(mi.Bitmap(str(out / "picture.exr")).convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.Float32, False))


def blocks(picture, covered):
    """Mean colour of each block that is covered to the full."""
    high, wide = HEIGHT // BLOCK, WIDTH // BLOCK
    cut = lambda values: values.reshape(high, BLOCK, wide, BLOCK, -1).mean(axis=(1, 3)).reshape(high * wide, -1)
    return cut(picture)[cut(covered.astype(float))[:, 0] > 0.999]


def norms(of, truth):
    return np.sqrt(((of - truth) ** 2).sum(axis=0) / (truth ** 2).sum(axis=0))


def shown(radiance, exposure):
    return mi.Bitmap((exposure * radiance).astype(np.float32)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True)


def differences(of, truth, covered):
    """Of luminance, block by block: pixels of Mitsuba are noise."""
    weights = np.array([0.2126, 0.7152, 0.0722])
    means = lambda values: np.kron((values * covered).reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK).sum(axis=(1, 3)), np.ones((BLOCK, BLOCK)))
    relative = (means(of @ weights) / np.maximum(means(truth @ weights), 1e-9) - 1.0) / FULL
    stops = np.array([[5, 48, 140], [245, 245, 245], [160, 10, 30]], float)
    place = np.clip(relative, -1.0, 1.0)[..., None]
    colours = np.where(place < 0.0, stops[1] + (stops[0] - stops[1]) * -place, stops[1] + (stops[2] - stops[1]) * place)
    return np.where(covered[..., None], colours, 0.0).astype(np.uint8)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("program")
    arguments.add_argument("-o", "--out", type=pathlib.Path, required=True)
    arguments.add_argument("--samples", type=int, default=256, help="per pixel of each of two runs of Mitsuba")
    arguments.add_argument("--models", default="embedded")
    arguments.add_argument("--variant", default="scalar_rgb")
    options = arguments.parse_args()
    mi.set_variant(options.variant)
    folder = options.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    rows, plate = [], []
    for voxels in (False, True):
        loaded = mitsuba_scene(voxels)
        processor = time.process_time()
        halves = [np.array(mi.render(loaded, spp=options.samples, seed=seed))[..., :3].astype(float) for seed in (1, 2)]
        seconds = time.process_time() - processor
        truth = 0.5 * (halves[0] + halves[1])
        exposure, line = None, []
        for model in options.models.split(","):
            ours = our_picture(options.program, folder, voxels, model, 0.02 if model != "montecarlo" else 0.03)
            covered = ours[..., 3] > 0.999
            own = ours[..., :3].astype(float)
            reference = blocks(truth, covered)
            if exposure is None:
                exposure = 0.6 / np.percentile(truth[covered] @ [0.2126, 0.7152, 0.0722], 95)
                line.append(np.array(shown(truth * covered[..., None], exposure)))
            line += [np.array(shown(own * covered[..., None], exposure)), differences(own, truth, covered)]
            rows.append({"scene": "volume" if voxels else "one material", "model": model,
                         "mean": (blocks(own, covered).mean(axis=0) / reference.mean(axis=0) - 1.0).tolist(),
                         "norm": norms(blocks(own, covered), reference).tolist(),
                         "norm of Mitsuba's noise": (0.5 * norms(blocks(halves[0], covered), blocks(halves[1], covered))).tolist(),
                         "blocks": len(reference), "seconds of processor, Mitsuba": seconds})
            print(json.dumps(rows[-1]), flush=True)
        plate.append(np.concatenate(line, axis=1))
    mi.Bitmap(np.concatenate(plate, axis=0)).write(str(folder / "plate.png"))
    (folder / "plate.json").write_text(json.dumps({"mitsuba": mi.__version__, "variant": options.variant, "samples": 2 * options.samples,
                                                   "rows": rows}, indent=1))


if __name__ == "__main__":
    main()

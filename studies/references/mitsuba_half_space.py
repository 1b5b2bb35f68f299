#!/usr/bin/env python3
"""Pictures of half-spaces under sinusoidal light by Mitsuba 3's random walk, for `kappamu map`.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    nice venv/bin/python studies/references/mitsuba_half_space.py FOLDER [--passes 50]
    kappamu map FOLDER/pictures -o FOLDER/maps && venv/bin/python studies/references/mitsuba_half_space.py FOLDER --compare

A perspective camera looks straight down on a block of 200 x 200 x 60 mm with smooth dielectric faces; walks are long
lost before they find its sides. Light is a ring about the camera, in a cone of 22 degrees without its innermost 8, so that
the surface mirrors none of it into the camera. Walks find the ring by chance (mitsuba_photographs.py). A slide on the surface
colours light by its cell of 0.5 mm, that of a camera pixel; a walk passes it on its way in and out, and the cell of the way in
is the pixel's own. So one rendering serves every spatial frequency and phase. Light does not change along the rows' direction:
every row of a picture is the mean of all, whose noise is 1 %.
"""
import argparse
import json
import pathlib

import mitsuba as mi
import numpy as np

CONE, STOP = np.radians((22.0, 8.0))
FAR, CAMERA = 500.0, 300.0  # mm above the surface: ring and camera
PIXELS, CELL = 64, 0.5  # of the camera, along each side, and their edge on the surface [mm]
CELLS = 400  # of the slide, along each side
GAP = 2e-3  # mm between slide and surface
FINE = 5  # walks a pixel and pass, along each side
FREQUENCIES = (0.0, 0.05, 0.1, 0.2, 0.3)  # 1/mm
PHASES = (0, 120, 240)
ETA, G = 1.4, 0.8
MEDIA = {"sample": (1.1, 0.03), "reference": (1.5, 0.012)}  # sigma_s', mu_a [1/mm]


def scene(scattering, absorption):
    extinction = scattering / (1 - G) + absorption
    t = mi.ScalarTransform4f
    column, row = np.meshgrid(np.arange(CELLS) + 1.0, np.arange(CELLS) + 1.0)
    colours = np.stack([np.ones_like(row), column / CELLS, row / CELLS], axis=-1).astype(np.float32)
    half = CELLS * CELL / 2
    radiance = float(1 / np.pi / (np.sin(CONE) ** 2 - np.sin(STOP) ** 2))  # irradiance 1 on the surface
    down = t().rotate([1, 0, 0], 180)
    return mi.load_dict({
        "type": "scene", "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 1000000},
        "block": {"type": "cube", "to_world": t().translate([0, 0, -30]).scale([100, 100, 30]),
                  "bsdf": {"type": "dielectric", "int_ior": ETA, "ext_ior": 1.0},
                  "interior": {"type": "homogeneous", "sigma_t": extinction, "albedo": 1 - absorption / extinction,
                               "phase": {"type": "hg", "g": G}, "sample_emitters": False}},
        "slide": {"type": "rectangle", "to_world": t().translate([0, 0, GAP]).scale([half, half, 1]),
                  "bsdf": {"type": "thindielectric", "int_ior": 1.0, "ext_ior": 1.0,
                           "specular_transmittance": {"type": "bitmap", "bitmap": mi.Bitmap(colours), "raw": True,
                                                      "filter_type": "nearest", "wrap_mode": "clamp"}}},
        "ring": {"type": "disk", "to_world": t().translate([0, 0, FAR]) @ down @ t().scale([FAR * np.tan(CONE)] * 3),
                 "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}},
        "stop": {"type": "disk", "to_world": t().translate([0, 0, FAR - 1]) @ down @ t().scale([FAR * np.tan(STOP)] * 3),
                 "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}},
        "camera": {"type": "perspective", "fov": float(np.degrees(2 * np.arctan(PIXELS * CELL / 2 / (CAMERA - GAP)))),
                   "to_world": t().look_at([0, 0, CAMERA], [0, 0, 0], [0, 1, 0]), "near_clip": 1.0,
                   "film": {"type": "hdrfilm", "width": FINE * PIXELS, "height": FINE * PIXELS, "rfilter": {"type": "box"},
                            "component_format": "float32"},
                   "sampler": {"type": "independent"}}})


def walks(medium, passes, seed):
    """Of every walk that found the ring: its camera pixel (v, u), weight, and place of the light's entry [mm] from the middle."""
    world = scene(*medium)
    found = []
    for n in range(passes):
        seen = np.array(mi.render(world, spp=1, seed=seed + n)).astype(float)
        v, u = np.nonzero(seen[..., 0])
        found.append([v, u, *seen[v, u].T])
        print("pass", n, len(v), "walks", flush=True)
    v, u, weight, column, row = np.concatenate(found, axis=1)
    v, u = v.astype(int) // FINE, u.astype(int) // FINE
    return v, u, weight, CELLS * column / weight, CELLS * row / weight


def pictures(medium, passes, seed):
    """By frequency: one picture [v][u] by phase, 1 where all light of an irradiance of 1 left evenly."""
    v, u, weight, column, row = walks(medium, passes, seed)
    # The camera's x goes to its right, its rows down; the slide's numbers grow along x, y of its own: by which of both
    # directions the pixel's own cell divides out is seen by what leaves whole numbers.
    best = None
    for own_column in (CELLS // 2 - PIXELS // 2 + u + 1, CELLS // 2 + PIXELS // 2 - u):
        for own_row in (CELLS // 2 - PIXELS // 2 + v + 1, CELLS // 2 + PIXELS // 2 - v):
            entry = np.stack([CELLS * column / own_column, CELLS * row / own_row])
            whole = np.mean(np.abs(entry - np.rint(entry)) < 0.02)
            if best is None or whole > best[0]:
                best = whole, entry, own_column
    whole, entry, own_column = best
    print(f"{100 * whole:.2f} % of the walks name their cells", flush=True)
    kept = np.all(np.abs(entry - np.rint(entry)) < 0.02, axis=0)
    turned = own_column[np.argmax(u)] < own_column[np.argmin(u)]
    x = (np.rint(entry[0]) - (CELLS + 1) / 2) * (-CELL if turned else CELL)  # along the camera's u
    made = {}
    for f in FREQUENCIES:
        made[f] = []
        for phase in PHASES if f else (0,):
            light = 0.5 + 0.5 * np.sinc(f * CELL) * np.cos(2 * np.pi * f * x + np.radians(phase)) if f else np.ones_like(x)
            mean = np.bincount(u[kept], (weight * light)[kept], PIXELS) / (PIXELS * passes * FINE**2)
            made[f].append(np.tile(np.pi * mean, (PIXELS, 1)).astype(np.float32))
    return made


def shoot(folder, passes):
    out = folder / "pictures"
    out.mkdir(parents=True, exist_ok=True)
    names = {}
    for seed, (name, medium) in enumerate(MEDIA.items()):
        for f, images in pictures(medium, passes, 1000 * seed).items():
            for n, image in enumerate(images):
                names.setdefault((name, f), []).append(f"{name}_{f:g}_{n}.npy")
                np.save(out / names[name, f][-1], image)
    scattering, absorption = MEDIA["reference"]
    sfdi = {"format": "kappamu-sfdi", "version": 1, "pixel_mm": CELL,
            "medium": {"refractive_index": ETA, "anisotropy": G}, "smoothing_mm": 2,
            "region_px": [4, 4, PIXELS - 8, PIXELS - 8],
            "reference": {"coefficients": [{"wavelength_nm": 660, "absorption_per_mm": absorption,
                                            "reduced_scattering_per_mm": scattering}]},
            "measurements": [{"wavelength_nm": 660, "per_mm": f, "sample": names["sample", f], "reference": names["reference", f]}
                             for f in FREQUENCIES]}
    (out / "sfdi.json").write_text(json.dumps(sfdi, indent=1))


def compare(folder):
    """Of the whole picture: measured, its deviation, and the truth."""
    region = json.loads((folder / "maps/summary.json").read_text())["wavelengths"][0]["region"]
    scattering, absorption = MEDIA["sample"]
    for name, truth in (("mua", absorption), ("musp", scattering)):
        print(f"{name} {region[name]:.4g} +- {region[name + '_deviation']:.2g} /mm, truth {truth} ({100 * (region[name] / truth - 1):+.1f} %)")


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--passes", type=int, default=50, help="of 25 walks a pixel")
    arguments.add_argument("--compare", action="store_true")
    options = arguments.parse_args()
    if options.compare:
        compare(options.folder)
    else:
        mi.set_variant("scalar_rgb")
        shoot(options.folder, options.passes)


if __name__ == "__main__":
    main()

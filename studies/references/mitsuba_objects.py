#!/usr/bin/env python3
"""Mitsuba 3's volpath on the scenes of tests/render/object_monte_carlo_mitsuba_test.cpp.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    venv/bin/python studies/references/mitsuba_objects.py [--runs 32] [--samples 25000]

A box of 4 x 3 x 2 mm, eta 1.3, centred at the origin, with a diffuse light of irradiance 1 all over
its top (z+), homogeneous and of 4 x 3 x 2 voxels. Printed are the mean exitance and its standard
error, from the spread of the runs, on 2 x 2 patches of the bottom (z-) and of the side x+, in the
order of the test's tables. The light and the irradiance meters are black rectangles 2e-3 mm before
the faces. Smooth dielectrics hide directional lights from path tracing, so the light is diffuse.
The volume needs a Mitsuba in which `heterogeneous` weighs absorption right (3.6 or later).
"""
import argparse

import mitsuba as mi
import numpy as np

SIZE = np.array([4.0, 3.0, 2.0])  # mm
GAP = 2e-3  # mm; several times the offset of rays in single precision
ETA = 1.3


def medium(voxels):
    """Isotropic, sigma_t in 1/mm: one value each, or arrays [z][y][x], nearest voxel."""
    if not voxels:
        return {"type": "homogeneous", "sigma_t": 2.02, "albedo": 2.0 / 2.02}
    k, j, i = np.meshgrid(range(2), range(3), range(4), indexing="ij")
    sigma_t = 1.0 + (3 * i + 5 * j + 7 * k) % 5
    albedo = 0.90 + 0.02 * ((i + 2 * j + 3 * k) % 5)
    to_world = mi.ScalarTransform4f().scale(SIZE.tolist()).translate([-0.5, -0.5, -0.5])

    def grid(values):
        return {"type": "gridvolume", "grid": mi.VolumeGrid(values[..., None].astype(np.float32)),
                "filter_type": "nearest", "wrap_mode": "clamp", "raw": True, "to_world": to_world}

    return {"type": "heterogeneous", "sigma_t": grid(sigma_t), "albedo": grid(albedo), "scale": 1.0}


def meter(to_world):
    return {"type": "rectangle", "to_world": to_world,
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
            "sensor": {"type": "irradiancemeter",
                       "film": {"type": "hdrfilm", "width": 2, "height": 2, "pixel_format": "luminance",
                                "rfilter": {"type": "box"}},
                       "sampler": {"type": "independent"}}}


def scene(voxels):
    half = SIZE / 2
    t = mi.ScalarTransform4f
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 50},
        "object": {"type": "cube", "to_world": t().scale(half.tolist()),
                   "bsdf": {"type": "dielectric", "int_ior": ETA, "ext_ior": 1.0},
                   "interior": medium(voxels)},
        "light": {"type": "rectangle",
                  "to_world": t().translate([0, 0, half[2] + GAP]).rotate([1, 0, 0], 180)
                  .scale([half[0], half[1], 1.0]),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
                  "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0 / np.pi}}},
        "bottom": meter(t().translate([0, 0, -half[2] - GAP]).scale([half[0], half[1], 1.0])),
        # Its x lies along the object's z, its y along y; it looks towards x-.
        "side": meter(t().translate([half[0] + GAP, 0, 0]).rotate([0, 1, 0], -90)
                      .scale([half[2], half[1], 1.0])),
    }, optimize=False)  # it would make one of the two meters


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--runs", type=int, default=32)
    arguments.add_argument("--samples", type=int, default=25000)
    options = arguments.parse_args()
    mi.set_variant("scalar_rgb")
    print("Mitsuba", mi.__version__, "volpath, scalar_rgb,", options.runs, "runs of", options.samples)
    for voxels in (False, True):
        loaded = scene(voxels)
        sensors = dict(zip(("bottom", "side"), loaded.sensors()))
        for face in ("bottom", "side"):
            runs = np.array([np.array(mi.render(loaded, sensor=sensors[face], spp=options.samples,
                                                seed=run))[..., 0] for run in range(options.runs)])
            error = runs.std(axis=0, ddof=1) / np.sqrt(options.runs)
            print("voxels" if voxels else "homogeneous", face, "[v][u]")
            print("  mean ", np.array2string(runs.mean(axis=0), precision=6, separator=", "))
            print("  error", np.array2string(error, precision=6, separator=", "), flush=True)


if __name__ == "__main__":
    main()

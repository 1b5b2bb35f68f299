#!/usr/bin/env python3
"""A capture session whose photographs are Mitsuba 3's: a block of known volume, seen by another random walk.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 numpy
    nice venv/bin/python studies/references/mitsuba_photographs.py FOLDER [--g 0.8] [--turn 30] [--passes 16]

Writes FOLDER/session and FOLDER/truth (kappa_Y.npy, mu_Y.npy [z][y][x], similarity-reduced). Boards, targets and
the place of everything are those of tests/app/handwritten_session.py. The block has open, smooth dielectric
faces; its voxels are constant, its phase function Henyey-Greenstein's.

volpath cannot connect a point in the block to a light through smooth glass: walks find the light by chance.
The projector's lens is therefore wide: a ring that fills a cone of 22 degrees about the normal but for its
innermost 8, where the camera would look through the block into the lens. Its picture stands before the lit
face as a slide, as of a projector focused on it. The slide's colours tell from which of the projector's pixels
a walk got its light, so that one rendering, a walk a pixel, serves every pattern. Walks that find the lens are
counted: their noise is Poisson's. Exposures are so short that as many electrons as walks are collected: the
noise in the pictures is the noise that the session states.
"""
import argparse
import importlib.util
import pathlib
import sys

import mitsuba as mi
import numpy as np

CONE, STOP = np.radians((22.0, 8.0))
FAR = 500.0  # mm from lens to block
GAP = 2e-3  # mm between slide and face
MARGIN = 120  # projector pixels of slide beyond the face: no light beside the block
LARGEST = 2000.0  # above the numbers of the slide's columns and rows
FRAMES = 4  # of each pattern
FINE = 5  # walks a camera pixel and pass, along each side


def handwritten(folder):
    """The module of the handwritten session, writing into `folder` with a sensor of little noise."""
    path = pathlib.Path(__file__).parents[2] / "tests/app/handwritten_session.py"
    spec = importlib.util.spec_from_file_location("handwritten_session", path)
    rig = importlib.util.module_from_spec(spec)
    arguments, sys.argv = sys.argv, [str(path), str(folder)]
    spec.loader.exec_module(rig)
    sys.argv = arguments
    rig.FOLDER, rig.BITS, rig.BLACK, rig.TOP, rig.READ = folder, 16, 1000.0, 65535, 0.5
    return rig


def volume(grid, homogeneous):
    """sigma_s' and mu [1/mm], [z][y][x]: a stained and a clear inclusion in a plain block."""
    scattering, absorption = np.full(grid[::-1], 1.2), np.full(grid[::-1], 0.01)
    if not homogeneous:
        absorption[2:5, 2:5, 2:5] = 0.08
        scattering[1:4, 5:8, 7:10] = 0.6
    return scattering, absorption


def block(rig, scattering, absorption, g):
    extinction = scattering / (1 - g) + absorption
    t = mi.ScalarTransform4f
    size = rig.SIZE.tolist()
    middle = (rig.SIZE / 2).tolist()

    def voxels(values):
        return {"type": "gridvolume", "grid": mi.VolumeGrid(values[..., None].astype(np.float32)),
                "filter_type": "nearest", "wrap_mode": "clamp", "raw": True, "to_world": t().scale(size)}

    return {"type": "cube", "to_world": t().translate(middle).scale(middle),
            "bsdf": {"type": "dielectric", "int_ior": rig.ETA, "ext_ior": 1.0},
            "interior": {"type": "heterogeneous", "sigma_t": voxels(extinction),
                         "albedo": voxels(1 - absorption / extinction), "scale": 1.0,
                         "phase": {"type": "hg", "g": g}, "sample_emitters": False}}


def slide(rig):
    """A slide on the lit face that colours light by the projector's pixel: 1, column and row of `window`, from 1.

    The projector stands straight before the face. The window, first column and row and their numbers, holds the
    face and a margin, so that no light passes beside the slide.
    """
    scale = 50.0 / rig.THROW  # mm a pixel
    low = [int(np.floor((rig.PROJECTOR[a] - 1) / 2 - rig.SIZE[a] / 2 / scale)) - MARGIN for a in range(2)]
    number = [int(np.ceil(rig.SIZE[a] / scale)) + 2 * MARGIN for a in range(2)]
    columns, rows = np.meshgrid(np.arange(number[0]) + 1.0, np.arange(number[1]) + 1.0)
    colours = np.stack([np.ones_like(rows), columns / LARGEST, rows / LARGEST], axis=-1).astype(np.float32)
    centre = [(low[a] + (number[a] - 1) / 2 - (rig.PROJECTOR[a] - 1) / 2) * scale + rig.MIDDLE[a] for a in range(2)]
    half = [number[a] * scale / 2 for a in range(2)]
    return {"type": "rectangle",
            "to_world": mi.ScalarTransform4f().translate([*map(float, centre), -GAP]).scale([*half, 1.0]),
            "bsdf": {"type": "thindielectric", "int_ior": 1.0, "ext_ior": 1.0,
                     "specular_transmittance": {"type": "bitmap", "bitmap": mi.Bitmap(colours),
                                                "raw": True, "filter_type": "nearest", "wrap_mode": "clamp"}}
            }, low, number


def camera(rig, pose):
    """Pinhole at the station of the back, and the window of its picture that holds the block."""
    rotation, shift = pose
    corners = np.array([[x, y, z] for x in (0, rig.SIZE[0]) for y in (0, rig.SIZE[1]) for z in (0, rig.SIZE[2])])
    seen = corners @ rotation.T + shift
    pixels = rig.FOCAL * seen[:, :2] / seen[:, 2:] + (np.array(rig.CAMERA) - 1) / 2
    low = np.floor(pixels.min(axis=0)).astype(int) - 4
    high = np.ceil(pixels.max(axis=0)).astype(int) + 5
    to_world = np.eye(4)
    to_world[:3, :3] = rotation.T @ np.diag([-1.0, -1.0, 1.0])  # Mitsuba: x left, y up
    to_world[:3, 3] = -rotation.T @ shift
    return {"type": "perspective", "to_world": mi.ScalarTransform4f(to_world), "fov_axis": "x",
            "fov": float(np.degrees(2 * np.arctan(rig.CAMERA[0] / 2 / rig.FOCAL))), "near_clip": 1.0,
            "film": {"type": "hdrfilm", "width": FINE * rig.CAMERA[0], "height": FINE * rig.CAMERA[1],
                     "crop_offset_x": int(FINE * low[0]), "crop_offset_y": int(FINE * low[1]),
                     "crop_width": int(FINE * (high[0] - low[0])), "crop_height": int(FINE * (high[1] - low[1])),
                     "rfilter": {"type": "box"}, "component_format": "float32"},
            "sampler": {"type": "independent"}}, low, high


class Walks:
    """Mitsuba's pictures of the block, one walk a pixel: where each began in the camera and left the lit face."""

    def __init__(self, rig, shape):
        self.rig = rig
        sensor, self.low, self.high = camera(rig, rig.BACK)
        picture, self.slide_low, self.slide_number = slide(rig)
        radiance = float(1 / np.pi / (np.sin(CONE) ** 2 - np.sin(STOP) ** 2))  # irradiance 1 on the face
        self.scene = mi.load_dict({
            "type": "scene", "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 1000000},
            "block": shape, "slide": picture, "camera": sensor,
            "lens": {"type": "disk", "to_world": mi.ScalarTransform4f()
                     .translate([*rig.MIDDLE[:2].tolist(), -FAR]).scale([FAR * np.tan(CONE)] * 3),
                     "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}},
            "stop": {"type": "disk", "to_world": mi.ScalarTransform4f()
                     .translate([*rig.MIDDLE[:2].tolist(), 1.0 - FAR]).scale([FAR * np.tan(STOP)] * 3),
                     "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}})

    def radiance(self, images, passes, seed):
        """Under each picture of the projector [picture][v][u] in the camera's window, mean of `passes` pictures."""
        width, height = self.high - self.low
        sums = np.zeros((len(images), height * width))
        light = [np.maximum(image / 255.0, self.rig.PROJECTOR_BLACK) for image in images]
        for n in range(passes):
            seen = np.array(mi.render(self.scene, spp=1, seed=seed + n)).astype(float)
            v, u = np.nonzero(seen[..., 0])
            weight, column, row = seen[v, u].T
            column = np.rint(LARGEST * column / weight).astype(int) - 1 + self.slide_low[0]
            row = np.rint(LARGEST * row / weight).astype(int) - 1 + self.slide_low[1]
            pixel = v // FINE * width + u // FINE
            for sum_, value in zip(sums, light):
                sum_ += np.bincount(pixel, weight * value[row, column], height * width)
        return sums.reshape(len(images), height, width) / (passes * FINE**2)


def projector_pictures(rig):
    """Bars to fit, patches to validate: name, role, picture."""
    def picture(x0, x1, y0, y1):
        image = np.zeros((rig.PROJECTOR[1], rig.PROJECTOR[0]))
        edges = [np.round((np.array(pair) - rig.MIDDLE[a]) * rig.THROW / 50 + (rig.PROJECTOR[a] - 1) / 2).astype(int)
                 for a, pair in enumerate(((x0, x1), (y0, y1)))]
        image[edges[1][0]:edges[1][1], edges[0][0]:edges[0][1]] = 255
        return image

    width, height = rig.SIZE[:2]
    bars = [(i * width / 4, (i + 1) * width / 4, 0, height) for i in range(4)]
    bars += [(0, width, i * height / 3, (i + 1) * height / 3) for i in range(3)]
    held = [(0.1 * width, 0.4 * width, 0.1 * height, 0.5 * height), (0.5 * width, 0.9 * width, 0.4 * height, 0.9 * height)]
    return ([(f"fit_{i:02d}", "fit", picture(*bar)) for i, bar in enumerate(bars)] +
            [(f"held_{i:02d}", "validate", picture(*patch)) for i, patch in enumerate(held)])


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--g", type=float, default=0.0)
    arguments.add_argument("--passes", type=int, default=16, help="of 25 walks a pixel, for each of four frames")
    arguments.add_argument("--turn", type=float, default=1.0, help="the camera's, from the normal of the seen face [degrees]")
    arguments.add_argument("--homogeneous", action="store_true", help="without inclusions")
    options = arguments.parse_args()
    mi.set_variant("scalar_rgb")
    rig = handwritten(options.folder / "session")
    rig.BACK = rig.looking(54.0, options.turn, rig.MIDDLE + [0, 0, rig.SIZE[2]], True)
    (options.folder / "truth").mkdir(parents=True)
    scattering, absorption = volume(rig.GRID, options.homogeneous)
    np.save(options.folder / "truth/kappa_Y.npy", (1 / (3 * (scattering + absorption))).astype(np.float32))
    np.save(options.folder / "truth/mu_Y.npy", absorption.astype(np.float32))
    walks = Walks(rig, block(rig, scattering, absorption, options.g))
    pictures = projector_pictures(rig)
    radiance = []
    for frame in range(FRAMES):
        radiance.append(walks.radiance([p[2] for p in pictures], options.passes, 1000 * frame))
        print("frame", frame, "mean radiance", radiance[-1].mean(axis=(1, 2)), flush=True)
    radiance = np.array(radiance)
    np.save(options.folder / "truth/radiance.npy", radiance.astype(np.float32))
    # Electrons for unit radiance, so that the variance over frames is the mean in electrons.
    electrons = radiance.mean() / radiance.var(axis=0, ddof=1).mean()
    exposure = float(electrons / rig.RESPONSIVITY / rig.ELECTRONS)
    low, high = walks.low, walks.high
    chance = np.random.default_rng(2)
    patterns = []
    for number, (name, role, image) in enumerate(pictures):
        rig.write_png(rig.FOLDER / f"patterns/{name}.png", image, 8)
        frames = []
        for n in range(FRAMES):
            signal = np.zeros((rig.CAMERA[1], rig.CAMERA[0]))
            signal[low[1]:high[1], low[0]:high[0]] = electrons / rig.ELECTRONS * radiance[n, number]
            # A walk is a few codes: rounded up or down by chance, or their mean would be off.
            codes = np.clip(np.floor(rig.BLACK + (rig.TOP - rig.BLACK) * signal + chance.random(signal.shape)), 0, rig.TOP)
            frames.append({"file": f"frames/{name}_{n}.png", "exposure_s": exposure})
            rig.write_png(rig.FOLDER / frames[-1]["file"], codes, 16)
        patterns.append({"id": name, "image": f"patterns/{name}.png", "role": role, "frames": frames})
    session = rig.session(patterns)
    session["description"] = (f"Mitsuba {mi.__version__} volpath, g {options.g}, "
                              f"{FRAMES * options.passes * FINE**2} walks a pixel")
    session["sample"]["sides"] = "open"
    session["camera"] |= {"bit_depth": rig.BITS, "electrons_full_scale": rig.ELECTRONS, "read_noise_electrons": rig.READ}
    with open(rig.FOLDER / "session.json", "w") as out:
        rig.json.dump(session, out, indent=1)
    print(f"{electrons * radiance.mean():.2f} electrons a pixel and frame, exposure {exposure:.3g} s")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes a capture session as docs/formats.md describes it, without kappamu: NumPy and the standard library.

    handwritten_session.py FOLDER [bars]

With `bars` the block is larger, eight bars side by side light it, and its photographs are interpolated
between samples half a voxel apart: with the bars' edges rounded to projector pixels, measurements are
some tenths of a per cent wrong. A grey camera (pinhole) and a projector look at a homogeneous block between mirrors, whose exitance is
known in closed form: cosines across, exponentials through the depth. Prints kappa [mm] and mu [1/mm].
"""
import json
import pathlib
import struct
import sys
import zlib

import numpy as np

# The block [mm], its optics, and the rig.
BARS = sys.argv[2:] == ["bars"]
GRID, VOXEL, ETA = (20, 16, 8) if BARS else (12, 10, 6), 0.6, 1.3
SIZE = np.array(GRID) * VOXEL
MU = 0.01  # 1/mm
SCATTERING = 1 / (3 * 0.35) - MU if BARS else 1.5  # reduced, 1/mm
KAPPA = 1.0 / (3.0 * (SCATTERING + MU))
CAMERA, FOCAL, POINTS = (480, 360), 1440.0, 6  # px, px, rays per pixel and side
PROJECTOR, THROW = (1024, 768), 3584.0
BITS, BLACK, ELECTRONS, READ = 12, 60.0, 20000.0, 5.0
TOP = 2**BITS - 1
RESPONSIVITY = 40.0  # full scales per second for unit radiance
PROJECTOR_BLACK = 1.0 / 3000.0
REFLECTANCE = 0.99
BOARD = {"columns": 9, "rows": 6, "square_mm": 0.7}
PLANE_BOARD = (-7.0, -1.75)  # the printed board's inner corner (0, 0) on a plane, from its middle [mm]
PROJECTED = {"columns": 7, "rows": 5, "square_px": 60, "origin_px": [570, 250]}
noise = np.random.default_rng(1)


def write_png(path, codes, bits):
    """Grey PNG, filter 0 on every row (PNG specification, sections 5 and 11)."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = codes.astype(">u2" if bits == 16 else "u1")
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n")
        header = struct.pack(">IIBBBBB", codes.shape[1], codes.shape[0], bits, 0, 0, 0, 0)
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(raw, 1)), (b"IEND", b"")):
            out.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def turn(x, y, z):
    """Rotation by degrees about x, then y, then z."""
    x, y, z = np.radians((x, y, z))
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    about_z = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


# Poses are (R, t): camera = R x + t. The world is the sample frame; the lit face is z = 0.
MIDDLE = np.array([SIZE[0] / 2, SIZE[1] / 2, 0.0])


def looking(distance, degrees, point, back):
    """Camera `distance` mm from `point`, turned about y; `back` looks along -z, upright."""
    rotation = turn(0, degrees + (180 if back else 0), 0)
    return rotation, np.array([0, 0, distance]) - rotation @ point


FRONT = looking(54.0, 17.0, MIDDLE, False)
BACK = looking(54.0, 1.0, MIDDLE + [0, 0, SIZE[2]], True)
PROJECTOR_POSE = looking(50.0, 0.0, MIDDLE, False)


def on_plane(pose):
    """Where the rays of POINTS x POINTS points per camera pixel meet the plane z = 0 of a frame: x, y."""
    rotation, shift = pose
    u = (np.arange(POINTS * CAMERA[0]) + 0.5) / POINTS - 0.5
    v = (np.arange(POINTS * CAMERA[1]) + 0.5) / POINTS - 0.5
    rays = np.stack([*np.meshgrid((u - (CAMERA[0] - 1) / 2) / FOCAL, (v - (CAMERA[1] - 1) / 2) / FOCAL),
                     np.ones((v.size, u.size))], axis=-1)
    normal = rotation[:, 2]
    points = rays * (normal @ shift / (rays @ normal))[..., None] - shift
    return points @ rotation[:, 0], points @ rotation[:, 1]


def photograph(path, radiance, exposure_s):
    """POINTS x POINTS samples of radiance per pixel to a 12-bit PNG; gives its entry of session.json."""
    height, width = CAMERA[1], CAMERA[0]
    signal = RESPONSIVITY * exposure_s * radiance.reshape(height, POINTS, width, POINTS).mean(axis=(1, 3))
    signal = signal + noise.normal(size=signal.shape) * np.sqrt(signal * ELECTRONS + READ**2) / ELECTRONS
    codes = np.clip(np.rint(BLACK + (TOP - BLACK) * signal), 0, TOP)
    write_png(FOLDER / path, codes, 16)
    return {"file": path, "exposure_s": exposure_s}


def stack(name, radiance, exposures):
    return [photograph(f"{name}_{i}.png", radiance, t) for i, t in enumerate(exposures)]


def chessboard(x, y, columns, rows):
    """1 on white, 0 on black, in squares from inner corner (0, 0); one square of white around."""
    black = ((np.floor(x) + np.floor(y)) % 2 == 0) & (x >= -1) & (x < columns) & (y >= -1) & (y < rows)
    return 1.0 - black


def board_albedo(x, y):
    margin = (x > -2) & (x < BOARD["columns"] + 1) & (y > -2) & (y < BOARD["rows"] + 1)
    ink = chessboard(x, y, BOARD["columns"], BOARD["rows"])
    return np.where(margin, 0.04 + 0.81 * ink, 0.3)


def compose(a, b):
    return a[0] @ b[0], a[0] @ b[1] + a[1]


AMBIENT = 0.3  # irradiance of the room light where boards and sample are photographed


def camera_boards():
    frames = []
    middle = np.array([4.0, 2.5, 0.0]) * BOARD["square_mm"]
    for i in range(12):
        rotation = turn(*(28 * np.sin(2.4 * i), 28 * np.cos(1.7 * i), 6 * np.sin(3.1 * i)))
        distance = 50.0 + 6.0 * np.sin(1.3 * i)
        field = np.array([(i % 3 - 1) * 0.18 * CAMERA[0], (i // 3 % 3 - 1) * 0.15 * CAMERA[1]])
        at = np.append(field / FOCAL, 1.0) * distance
        x, y = on_plane((rotation, at - rotation @ middle))
        albedo = board_albedo(x / BOARD["square_mm"], y / BOARD["square_mm"])
        frames.append(photograph(f"calibration/board_{i:02d}.png", AMBIENT / np.pi * albedo, 0.2))
    return frames


def projector_pixels(world_from_plane, x, y):
    """Where points of a plane lie in the projector's picture."""
    rotation, shift = compose(PROJECTOR_POSE, world_from_plane)
    points = x[..., None] * rotation[:, 0] + y[..., None] * rotation[:, 1] + shift
    return (THROW * points[..., 0] / points[..., 2] + (PROJECTOR[0] - 1) / 2,
            THROW * points[..., 1] / points[..., 2] + (PROJECTOR[1] - 1) / 2)


def projector_planes():
    planes = []
    for i in range(8):
        tilt = turn(20 * np.sin(2.1 * i), 20 * np.cos(1.4 * i), 0)
        world_from_plane = (tilt, MIDDLE + [0.0, 0.0, 2.5 * np.sin(1.9 * i)])
        x, y = on_plane(compose(FRONT, world_from_plane))
        albedo = board_albedo((x - PLANE_BOARD[0]) / BOARD["square_mm"], (y - PLANE_BOARD[1]) / BOARD["square_mm"])
        albedo = np.where(x < 0, albedo, 0.85)  # its right half is blank
        u, v = projector_pixels(world_from_plane, x, y)
        i0, j0 = PROJECTED["origin_px"]
        column, row = (u - i0) / PROJECTED["square_px"], (v - j0) / PROJECTED["square_px"]
        lit = chessboard(column, row, PROJECTED["columns"], PROJECTED["rows"])
        lit *= (column > -2) & (column < PROJECTED["columns"] + 1)
        lit *= (row > -2) & (row < PROJECTED["rows"] + 1)
        light = np.where(lit > 0, 1.0, PROJECTOR_BLACK)
        name = f"calibration/plane_{i:02d}"
        planes.append({"board": photograph(f"{name}_board.png", AMBIENT / np.pi * albedo, 0.2),
                       "projected": photograph(f"{name}_projected.png", light / np.pi * albedo, 0.06)})
    return planes


def on_block(x, y):
    return (x > 0) & (x < SIZE[0]) & (y > 0) & (y < SIZE[1])


def sample_view(station, pose):
    x, y = on_plane(pose)
    return photograph(f"calibration/sample_{station}.png", AMBIENT / np.pi * np.where(on_block(x, y), 0.6, 0.01), 0.2)


def back_exitance(patch):
    """On a fine map [v][u] over the back face, for unit irradiance on the patch (x0, x1, y0, y1) [mm].

    Between mirrors the fluence is a sum of cos(pi m x/W) cos(pi n y/H) phi_mn(z), each with
    kappa phi'' - (mu + kappa k^2) phi = -sigma_s E_t exp(-sigma_t z), phi -+ 2 A kappa phi' = 0.
    """
    modes, fine = 48, 20
    width, height, depth = SIZE
    cosine = np.linspace(1e-6, 1, 20001)
    inside = np.sqrt(np.maximum(0, 1 - ETA**2 * (1 - cosine**2)))  # Fresnel from within
    s = (ETA * cosine - inside) / (ETA * cosine + inside)
    p = (cosine - ETA * inside) / (cosine + ETA * inside)
    fresnel = np.where(inside > 0, (s**2 + p**2) / 2, 1.0)
    a = (1 + np.trapz(3 * cosine**2 * fresnel, cosine)) / (1 - np.trapz(2 * cosine * fresnel, cosine))
    entering = 1 - ((ETA - 1) / (ETA + 1)) ** 2
    extinction = SCATTERING + MU

    def coefficients(low, high, length):
        m = np.arange(1, modes)
        rest = 2 / (np.pi * m) * (np.sin(np.pi * m * high / length) - np.sin(np.pi * m * low / length))
        return np.append((high - low) / length, rest)

    light = np.outer(coefficients(patch[2], patch[3], height), coefficients(patch[0], patch[1], width))
    k2 = (np.pi * np.arange(modes) / width) ** 2 + (np.pi * np.arange(modes)[:, None] / height) ** 2
    q = np.sqrt((MU + KAPPA * k2) / KAPPA)
    special = -SCATTERING * entering / (KAPPA * (extinction**2 - q**2))
    # phi = special exp(-extinction z) + b exp(-q z) + c exp(-q (depth - z))
    g, h, fall = 1 + 2 * a * KAPPA * q, 1 - 2 * a * KAPPA * q, np.exp(-q * depth)
    front = -special * (1 + 2 * a * KAPPA * extinction)
    back = -special * np.exp(-extinction * depth) * (1 - 2 * a * KAPPA * extinction)
    b = (front * g - back * h * fall) / (g * g - (h * fall) ** 2)
    c = (back - b * h * fall) / g
    fluence = special * np.exp(-extinction * depth) + b * fall + c
    u = (np.arange(GRID[0] * fine) + 0.5) / (GRID[0] * fine)
    v = (np.arange(GRID[1] * fine) + 0.5) / (GRID[1] * fine)
    return (np.cos(np.pi * np.outer(v, np.arange(modes))) @ (light * fluence) @
            np.cos(np.pi * np.outer(np.arange(modes), u))) / (2 * a), a


def interpolated(rows, step=10):
    """Rows of a map from every `step`-th of its values alone."""
    at = np.arange(rows.shape[1])
    return np.array([np.interp(at, at[::step], row[::step]) for row in rows])


def pattern(number, patch):
    """The projector's picture of a patch, and the photographs of the back face under it."""
    columns = np.round((np.array(patch[:2]) - MIDDLE[0]) * THROW / 50 + (PROJECTOR[0] - 1) / 2 - 0.5).astype(int)
    rows = np.round((np.array(patch[2:]) - MIDDLE[1]) * THROW / 50 + (PROJECTOR[1] - 1) / 2 - 0.5).astype(int)
    image = np.zeros((PROJECTOR[1], PROJECTOR[0]))
    image[rows[0] + 1:rows[1] + 1, columns[0] + 1:columns[1] + 1] = 255
    write_png(FOLDER / f"patterns/{number}.png", image, 8)
    exitance, a = back_exitance(patch)
    exitance = exitance + PROJECTOR_BLACK * back_exitance((0, SIZE[0], 0, SIZE[1]))[0]
    if BARS:
        exitance = interpolated(interpolated(exitance).T).T
    x, y = on_plane(compose(BACK, (np.eye(3), np.array([0, 0, SIZE[2]]))))
    at_v = np.clip(y / SIZE[1] * exitance.shape[0], 0, exitance.shape[0] - 1).astype(int)
    at_u = np.clip(x / SIZE[0] * exitance.shape[1], 0, exitance.shape[1] - 1).astype(int)
    # P1 radiance refracted out along the normal, which the rays are within some degrees of.
    along_normal = (1 - ((ETA - 1) / (ETA + 1)) ** 2) / ETA**2 * (2 * a + 3) / (4 * np.pi)
    radiance = np.where(on_block(x, y), exitance[at_v, at_u] * along_normal, 1e-6)
    return stack(f"frames/{number}", radiance, [0.04, 0.2, 1.0, 5.0])


def session(patterns):
    """session.json of these patterns, with the frames of its calibration."""
    everywhere = np.ones((POINTS * CAMERA[1], POINTS * CAMERA[0]))
    white = REFLECTANCE / np.pi * everywhere
    return {
        "format": "kappamu-session", "version": 1, "units": {"length": "mm", "time": "s"},
        "description": "written by hand", "setup": "back-lit", "channels": ["Y"],
        "sample": {"name": "by hand", "grid": GRID, "voxel_mm": VOXEL, "eta": ETA, "sides": "mirror",
                   "lit_face": "z-", "seen_face": "z+"},
        "camera": {"width": CAMERA[0], "height": CAMERA[1], "bit_depth": BITS, "encoding": "linear"},
        "projector": {"width": PROJECTOR[0], "height": PROJECTOR[1]},
        "stations": {"calibration": "front", "patterns": "back"},
        "patterns": patterns,
        "calibration": {
            "board": BOARD, "camera_boards": camera_boards(), "projected_board": PROJECTED,
            "projector_planes": projector_planes(),
            "sample_views": [
                {"station": "front", "face": "z-", "frame": sample_view("front", FRONT)},
                {"station": "back", "face": "z+",
                 "frame": sample_view("back", compose(BACK, (np.eye(3), np.array([0, 0, SIZE[2]]))))}],
            "dark": [photograph(f"calibration/dark_{i}.png", 0 * everywhere, 0.2) for i in range(2)],
            "white_target": {
                "reflectance": REFLECTANCE,
                "frames": stack("calibration/white", white, [0.01, 0.05]),
                "black_frames": stack("calibration/black", PROJECTOR_BLACK * white, [1.0, 5.0])}}}


def main():
    patterns = []
    columns, rows = (8, 1) if BARS else (2, 2)
    for j in range(rows):
        for i in range(columns):
            patch = (i * SIZE[0] / columns, (i + 1) * SIZE[0] / columns, j * SIZE[1] / rows, (j + 1) * SIZE[1] / rows)
            number = f"fit_{columns * j + i:02d}"
            patterns.append({"id": number, "image": f"patterns/{number}.png", "role": "fit",
                             "frames": pattern(number, patch)})
    held_out = (0.25 * SIZE[0], 0.6 * SIZE[0], 0.25 * SIZE[1], 0.75 * SIZE[1])
    patterns.append({"id": "held_00", "image": "patterns/held_00.png", "role": "validate",
                     "frames": pattern("held_00", held_out)})
    with open(FOLDER / "session.json", "w") as out:
        json.dump(session(patterns), out, indent=1)
    print(f"{KAPPA:.6f} {MU:.6f}")


if __name__ == "__main__":
    FOLDER = pathlib.Path(sys.argv[1])
    FOLDER.mkdir(parents=True)
    main()

#!/usr/bin/env python3
"""`kappamu merge` and HDRutils on the same camera RAW files: the table "Camera RAW of real size" of docs/hdr.md. Makes a bracket of DNG files
(Bayer RGGB, 14 bits, lossless JPEG as cameras write it) of a scene over four decades with shot and read noise, merges it by both,
and sets time, memory and error beside each other. The same bracket as 16-bit TIFF goes to `kappamu merge` alone: HDRutils reads
none. Needs, in the Python that runs this: pip install HDRutils imagecodecs.

    studies/references/hdr_raw.py build/app/kappamu out/ [6000x4000]
"""
import json
import logging
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

TIMES_S = np.geomspace(1 / 30, 8, 5)
DARKEST, BRIGHTEST = 0.003, 27.0  # full scales/s: saturated in the shortest frame from 30 on
COLOUR = np.array([0.6, 1.0, 0.5])
BLACK, WHITE, ELECTRONS, READ_NOISE = 512, 16383, 20000.0, 5.0
SITES = ((0, 1), (1, 2))  # R, G / G, B
DARK_FRAMES = 2


def radiance(width, height):
    """[x][channel] of every row."""
    ramp = DARKEST * (BRIGHTEST / DARKEST) ** ((np.arange(width) + 0.5) / width)
    return ramp[:, None] * COLOUR


def exposed(signal, random):
    """14-bit codes of a signal in full scales."""
    electrons = random.poisson(np.minimum(signal, 1.5) * ELECTRONS) + random.normal(0.0, READ_NOISE, signal.shape)
    codes = BLACK + (WHITE - BLACK) * electrons / ELECTRONS
    return np.clip(np.round(codes), 0, WHITE).astype("<u2")


def tiff(file, tags, data):
    """Little-endian TIFF of one directory; `tags` {number: (type, values)}, data in one strip."""
    sizes = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 10: 8}
    tags = dict(tags) | {273: (4, [8]), 279: (4, [len(data)])}
    entries, outside = b"", b""
    directory = 8 + len(data) + len(data) % 2
    free = directory + 2 + 12 * len(tags) + 4
    for number in sorted(tags):
        kind, values = tags[number]
        flat = np.ravel(values)
        packed = bytes(flat.astype("u1")) if kind < 3 else flat.astype({3: "<u2", 4: "<u4", 5: "<u4", 10: "<i4"}[kind]).tobytes()
        count = len(packed) // sizes[kind]
        if len(packed) > 4:
            packed += b"\0" * (len(packed) % 2)
            place, outside = free + len(outside), outside + packed
            packed = int(place).to_bytes(4, "little")
        entries += number.to_bytes(2, "little") + kind.to_bytes(2, "little") + count.to_bytes(4, "little") + packed.ljust(4, b"\0")
    head = b"II*\0" + directory.to_bytes(4, "little")
    file.write_bytes(head + data + b"\0" * (len(data) % 2) + len(tags).to_bytes(2, "little") + entries + b"\0" * 4 + outside)


def common_tags(width, height, exposure_s):
    text = np.frombuffer(b"Simulated\0", "u1")
    return {254: (4, [0]), 256: (4, [width]), 257: (4, [height]), 271: (2, text), 272: (2, text), 274: (3, [1]), 278: (4, [height]),
            33434: (5, [round(exposure_s * 1e6), 1000000]), 33437: (5, [8, 1]), 34855: (3, [100])}


def write_dng(file, codes, exposure_s):
    import imagecodecs
    height, width = codes.shape
    matrix = [[1, 1], [0, 1], [0, 1], [0, 1], [1, 1], [0, 1], [0, 1], [0, 1], [1, 1]]
    tags = common_tags(width, height, exposure_s) | {
        258: (3, [16]), 259: (3, [7]), 262: (3, [32803]), 277: (3, [1]), 33421: (3, [2, 2]), 33422: (1, SITES),
        50706: (1, [1, 4, 0, 0]), 50707: (1, [1, 1, 0, 0]), 50708: (2, np.frombuffer(b"Simulated\0", "u1")),
        50714: (4, [BLACK]), 50717: (4, [WHITE]), 50721: (10, matrix), 50728: (5, [[1, 1]] * 3)}
    tiff(file, tags, imagecodecs.ljpeg_encode(codes, bitspersample=14))


def write_tiff(file, codes, exposure_s):
    height, width, _ = codes.shape
    tags = common_tags(width, height, exposure_s) | {258: (3, [16] * 3), 259: (3, [1]), 262: (3, [2]), 277: (3, [3]), 284: (3, [1])}
    tiff(file, tags, codes.tobytes())


def write_frames(folder, kind, width, height):
    random = np.random.default_rng(1)
    folder.mkdir(parents=True, exist_ok=True)
    scene = np.broadcast_to(radiance(width, 1), (height, width, 3))
    names = [(f"dark_{k}", TIMES_S[-1], 0.0) for k in range(DARK_FRAMES)]
    names += [(f"frame_{k}", t, 1.0) for k, t in enumerate(TIMES_S)]
    for name, exposure_s, light in names:
        if kind == "dng":
            mosaic = np.empty((height, width))
            for y in range(2):
                for x in range(2):
                    mosaic[y::2, x::2] = scene[y::2, x::2, SITES[y][x]]
            write_dng(folder / f"{name}.dng", exposed(light * exposure_s * mosaic, random), exposure_s)
        else:
            write_tiff(folder / f"{name}.tif", exposed(light * exposure_s * scene, random), exposure_s)


def errors(found, width):
    """Relative RMS over four decades and the darkest of them, the common factor of each channel taken out."""
    truth = radiance(width, 1)[None]
    result = []
    ratios = found / truth
    ratios = ratios / np.median(ratios, axis=(0, 1))
    inner = ratios[2:-2, 2:-2]
    dark = np.broadcast_to(truth < 10 * DARKEST * COLOUR, found.shape)[2:-2, 2:-2]
    for kept in (np.ones_like(dark), dark):
        result.append(np.sqrt(np.mean((inner[kept] - 1) ** 2)))
    return result


def run(command):
    """Seconds by the clock, processor seconds, GB at the peak."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{said.decode()}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024e-9


def read_plain_exr(file):
    """Radiance R, G, B of an EXR without compression as `kappamu merge` writes it."""
    data = np.memmap(file, np.uint8, "r")
    text = bytes(data[:65536])
    at, window, channels = 8, None, []
    while text[at]:
        name, kind, rest = text[at:at + 512].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = int.from_bytes(text[at:at + 4], "little")
        value, at = text[at + 4:at + 4 + size], at + 4 + size
        if name == b"dataWindow":
            window = np.frombuffer(value, "<i4")
        while name == b"channels" and len(value) > 1:
            channel, value = value.split(b"\0", 1)
            channels.append((channel.decode(), int.from_bytes(value[:4], "little")))
            value = value[16:]
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    row = np.dtype([("head", "<i4", 2)] + [(name, "<f2" if kind == 1 else "<f4", width) for name, kind in channels])
    rows = np.frombuffer(data, row, height, at + 1 + 8 * int(height))
    return np.stack([rows[name] for name in "RGB"], -1)


def merge_by_hdrutils(folder, out):
    import HDRutils
    logging.disable(logging.WARNING)
    files = [str(folder / f"frame_{k}.dng") for k in range(len(TIMES_S))]
    merged, _ = HDRutils.merge(files, demosaic_first=False, color_space="raw", exp=list(TIMES_S), gain=[1.0] * len(files),
                               aperture=[1.0] * len(files))
    np.save(out, merged)


def main(kappamu, out, size):
    width, height = map(int, size.split("x"))
    rows = []
    print("| program, files | MB | s | processor s | GB | error | darkest decade |\n|" + "---|" * 7)

    def add(name, megabytes, cost, found):
        wall_s, processor_s, gigabytes = cost
        error, dark = errors(found, width)
        rows.append([name, megabytes, wall_s, processor_s, gigabytes, error, dark])
        print(f"| {name} | {megabytes:.0f} | {wall_s:.1f} | {processor_s:.1f} | {gigabytes:.2f} | {100 * error:.2f} % "
              f"| {100 * dark:.2f} % |", flush=True)

    for kind in ("dng", "tif"):
        folder = out / kind
        if not (folder / f"frame_{len(TIMES_S) - 1}.{kind}").exists():
            write_frames(folder, kind, width, height)
        megabytes = sum(file.stat().st_size for file in folder.glob(f"frame_*.{kind}")) * 1e-6
        merged = out / f"{kind}-merged"
        subprocess.run(["rm", "-rf", merged], check=True)
        cost = run([kappamu, "merge", folder, "-o", merged] + (["--linear"] if kind == "tif" else []))
        add(f"`kappamu merge`, {kind.upper()}", megabytes, cost, read_plain_exr(merged / "radiance.exr"))
        if kind == "dng":
            cost = run([sys.executable, __file__, "--hdrutils", folder, out / "hdrutils.npy"])
            add("HDRutils, DNG", megabytes, cost, np.load(out / "hdrutils.npy"))
    (out / "hdr_raw.json").write_text(json.dumps(rows))


if len(sys.argv) == 4 and sys.argv[1] == "--hdrutils":
    merge_by_hdrutils(pathlib.Path(sys.argv[2]), sys.argv[3])
elif len(sys.argv) in (3, 4):
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), (sys.argv[3:] or ["6000x4000"])[0])
else:
    sys.exit(__doc__)

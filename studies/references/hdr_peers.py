#!/usr/bin/env python3
"""pfstools and HDRutils on the frames of `kappamu-studies hdr --frames`, and pfstools on a real bracket: the tables of
docs/hdr.md. Needs Debian's pfstools and, in the Python that runs this, HDRutils (pip install HDRutils).

    kappamu-studies hdr --frames -o out/
    studies/references/hdr_peers.py out/ [shared/data/hdr-stlouis-arch]
"""
import json
import logging
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import colour_demosaicing
import HDRutils
import imageio.v3 as iio
import numpy as np

BRACKET_S = {"img00.jpg": 1 / 30, "img01.jpg": 1 / 4, "img02.jpg": 2.5, "img03.jpg": 15.0}  # EXIF


def pfs(images, times, options, scratch):
    """Radiance [y][x][channel], and CPU seconds of pfshdrcalibrate alone."""
    script = scratch / "stack.hdrgen"
    script.write_text("".join(f"{image} {1 / t:.9g} 1 100 0\n" for image, t in zip(images, times)))
    with open(scratch / "stack.pfs", "wb") as stack:
        subprocess.run(["pfsinhdrgen", script], stdout=stack, stderr=subprocess.DEVNULL, check=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(scratch / "stack.pfs", "rb") as stack, open(scratch / "merged.pfs", "wb") as merged:
        subprocess.run(["pfshdrcalibrate", *options], stdin=stack, stdout=merged, stderr=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(scratch / "merged.pfs", "rb") as merged:
        subprocess.run(["pfsoutpfm", scratch / "merged.pfm"], stdin=merged, stderr=subprocess.DEVNULL, check=True)
    _, size, scale, values = (scratch / "merged.pfm").read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    picture = np.frombuffer(values, "<f4" if float(scale) < 0 else ">f4").reshape(height, width, 3)[::-1]
    return picture, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def pfs_response(linear, file):
    """`linear` [code][channel] as pfshdrcalibrate reads it."""
    text = ""
    for c, name in enumerate(("IR", "IG", "IB")):
        text += (f"# Camera response curve, channel {name}\n# data layout: log10(response) | camera output | response\n"
                 f"# name: {name}\n# type: matrix\n# rows: {len(linear)}\n# columns: 3\n")
        text += "".join(f" {np.log10(max(v, 1e-6)):.9g} {code} {v:.9g}\n" for code, v in enumerate(linear[:, c])) + "\n"
    # The file must end with weights, which the merge by Poisson's law leaves unused.
    text += "# Weighting function\n# data layout: weight | camera output\n# name: W\n# type: matrix\n"
    text += f"# rows: {len(linear)}\n# columns: 2\n" + "".join(f" 1 {code}\n" for code in range(len(linear))) + "\n"
    file.write_text(text)


def hdrutils(images, times, linear, scratch):
    """Its merge takes one channel of linear codes (RAW); each of ours by turns, and nothing to demosaic."""
    colour_demosaicing.demosaicing_CFA_Bayer_bilinear = lambda mosaic, pattern: np.repeat(mosaic[..., None], 3, -1)
    codes = [iio.imread(image) for image in images]
    result, seconds = [], 0.0
    for c in range(3):
        files = []
        for i, picture in enumerate(codes):
            files.append(str(scratch / f"{i}.pgm"))  # it reads no TIFF, and PNG with FreeImage only
            values = np.round(65535 * linear[picture[..., c], c]).astype(">u2")
            pathlib.Path(files[-1]).write_bytes(b"P5\n%d %d\n65535\n" % values.shape[::-1] + values.tobytes())
        start = time.process_time()
        merged, _ = HDRutils.merge(files, demosaic_first=False, color_space="raw", exp=list(times),
                                   gain=[1.0] * len(files), aperture=1.0, bits=16)
        seconds += time.process_time() - start
        result.append(merged[..., 0])
    return np.stack(result, -1), seconds


def errors(found, truth, darkest, shortest_s):
    """As studies/hdr/hdr_error.cpp: four decades and the darkest of them, the common factor taken out."""
    kept = truth * shortest_s <= 0.9
    ratio = found[kept] / truth[kept]
    ratio /= np.median(ratio)
    dark = truth[kept] < 10 * darkest
    return [np.sqrt(np.mean((r - 1)**2)) for r in (ratio, ratio[dark])]


def simulated(out, scratch):
    record = json.loads((out / "hdr.json").read_text())
    scene = record["scene"]
    darkest, brightest = scene["radiance_full_scales_per_s"]
    linear = np.loadtxt(out / "frames" / "response.txt")
    pfs_response(linear, scratch / "response.m")
    x = (np.arange(scene["width"]) + 0.5) / scene["width"]
    truth = np.broadcast_to((darkest * (brightest / darkest)**x)[None, :, None], (scene["height"], scene["width"], 3))
    ours = {row["exposures"]: row for row in record["rows"] if row["method"] == "ours"}
    names = "ours | pfstools | pfstools, green | HDRutils"
    print(f"| exposures | {names} | darkest decade: {names} | CPU: ours | pfstools | HDRutils |\n|" + "---|" * 12)
    for count in (2, 3, 4, 6, 9):
        times = np.geomspace(*scene["exposures_s"], count)
        images = [out / "frames" / f"{count}_{i}.png" for i in range(count)]
        by_pfs, pfs_s = pfs(images, times, ["-f", scratch / "response.m"], scratch)
        by_hdrutils, hdrutils_s = hdrutils(images, times, linear, scratch)
        rows = [[ours[count]["relative_rms"], ours[count]["dark_rms"]]]
        rows += [errors(found, truth, darkest, times[0]) for found in (by_pfs, by_hdrutils)]
        rows.insert(2, errors(by_pfs[..., 1:2], truth[..., 1:2], darkest, times[0]))
        cells = [f"{100 * row[k]:.1f} %" for k in (0, 1) for row in rows]
        cells += [f"{1e3 * s:.0f} ms" for s in (ours[count]["seconds"], pfs_s, hdrutils_s)]
        print(f"| {count} | " + " | ".join(cells) + " |")


def real(folder, scratch):
    """By the test of docs/hdr.md: green pixels of codes 30 to 225 in both frames of a pair."""
    images, times = [folder / name for name in BRACKET_S], list(BRACKET_S.values())
    greens = [iio.imread(image)[..., 1] for image in images]
    truth = np.diff(np.log(times))
    print("\n| calibration | " + " | ".join(f"{t:.3f}" for t in truth) + " | mean absolute error | codes where the curve falls "
          "| 99.9 / 0.1 % | not finite | CPU |\n|" + "---|" * 8)
    for method in ("robertson", "mitsunaga"):
        curve = scratch / f"{method}.m"
        picture, seconds = pfs(images, times, ["-c", method, "-s", curve], scratch)
        green = curve.read_text().split("# Camera response curve, channel IG")[1].split("# Camera response")[0]
        linear = np.array([line.split()[2] for line in green.splitlines() if line and line[0] != "#"], float)
        ratios = []
        for a, b in zip(greens, greens[1:]):
            both = (np.minimum(a, b) >= 30) & (np.maximum(a, b) <= 225)
            ratios.append(np.median(np.log(linear[b[both]] / linear[a[both]])))
        luminance = picture @ np.array([0.2126, 0.7152, 0.0722])
        finite = np.isfinite(luminance)
        low, high = np.percentile(luminance[finite], [0.1, 99.9])
        print(f"| {method} | " + " | ".join(f"{r:.3f}" for r in ratios) + f" | {np.mean(np.abs(ratios - truth)):.3f} "
              f"| {np.sum(np.diff(linear) < 0)} | {high / low:.0f} | {np.sum(~finite)} | {seconds:.1f} s |")


if len(sys.argv) not in (2, 3):
    sys.exit(__doc__)
logging.disable(logging.WARNING)  # HDRutils tells of every file
with tempfile.TemporaryDirectory() as folder:
    simulated(pathlib.Path(sys.argv[1]), pathlib.Path(folder))
    if len(sys.argv) == 3:
        real(pathlib.Path(sys.argv[2]), pathlib.Path(folder))

#!/usr/bin/python3
"""Charts and tables of the records that `kappamu-studies` wrote.

    studies/bench_charts.py FOLDER              draws FOLDER/<record>.png and writes FOLDER/<record>.md
    studies/bench_charts.py FOLDER PAGE.md...   also renews the pages: the text between `<!-- bench:<record> -->`
                                                and `<!-- /bench -->`, and the pictures in images/ beside them

A record that was not measured leaves its place as it is. Needs Debian's python3-matplotlib.
"""
import json
import os
import pathlib
import re
import sys

import matplotlib.pyplot as plt
import numpy

from charts import fur
from charts.common import flat
from charts.devices import devices
from charts.diffusion import slabs, validity
from charts.figures import pictures as figure_pictures, samples as figure_samples, stairs, weights
from charts.forward import headline, kernels, peers, scaling, time_error
from charts.inverse import ablations, coverage, optimisers, patterns, samples, scores, uncertainty, voxels
from charts.limits import LIMITS
from charts.maps import map_pictures
from charts.objects import automatic, estimates, invariances, object_costs, objects, pictures, refinement
from charts.rig import calibration, hdr, rig
from charts.sfdi import peer
from charts.surfaces import form_factors, importance, polygrid_convergence, polygrid_frames, polygrid_quality


SUBJECTS = {"forward-headline": headline, "forward-kernels": kernels, "forward-peers": peers,
            "forward-grids": time_error, "forward-scaling": scaling, "devices": devices,
            "validity": validity, "slabs": slabs, "inverse-optimisers": optimisers,
            "inverse-scores": scores, "inverse-embedded": scores, "inverse-patterns": patterns,
            "inverse-voxels": voxels, "inverse-samples": samples,
            "inverse-validation": ablations, "inverse-regularisers": ablations, "inverse-losses": ablations, "inverse-population": ablations,
            "inverse-coverage": coverage,
            "uncertainty": uncertainty, "calibration": calibration, "rig": rig, "hdr": hdr, "sfdi-peer": peer,
            "polygrid-convergence": polygrid_convergence, "polygrid-frames": polygrid_frames,
            "polygrid-polygrid": polygrid_quality, "objects-refinement": refinement,
            "objects-estimate": estimates, "objects-picture": pictures, "objects-invariance": invariances,
            "objects-models": objects, "objects-cost": object_costs, "objects-auto": automatic,
            **{name: (lambda record: ({}, {"": flat(record["rows"], list(record["rows"][0]))}))
               for name in ("dipole-hierarchy", "dipole-profiles", "dipole-energy", "dipole-point-sampling")},
            "figures-pictures": figure_pictures, "figures-samples": figure_samples, "figures-weights": weights,
            "figures-stairs": stairs,
            "fur-figures": fur.sheets, "fur-reference": fur.reference, "fur-transfer": fur.transfer,
            **{f"fur-{name}": fur.numbers for name in ("coverage", "symmetry", "detail", "speed")},
             "dipole-importance": importance, "dipole-form-factors": form_factors,
            **{f"limits-{name}": (lambda record, made=made: ({}, {"": made(record["rows"])}))
               for name, made in LIMITS.items()}}


# ---- Files

def write(file, text):
    temporary = file.with_name(file.name + ".tmp")
    temporary.write_text(text)
    os.replace(temporary, file)


def draw(folder):
    """Pictures and texts of every record in the folder, by name."""
    drawn, texts = {}, {}
    for stem, make in SUBJECTS.items():
        file = folder / f"{stem}.json"
        if not file.exists():
            continue
        record = json.loads(file.read_text())
        if record.get("format") != "kappamu-bench-" + stem.split("-")[0] or record.get("version") != 2:
            raise SystemExit(f"bench_charts: {file} is no record of this version; remove it and measure again")
        record["folder"] = str(folder)
        try:
            figures, made = make(record)
        except KeyError as missing:
            raise SystemExit(f"bench_charts: {file} has no {missing}: another version measured it; measure again") from None
        for end, figure in figures.items():
            if stem in ("figures-pictures", "fur-figures"):  # photographs are a fifth as large as JPEG
                drawn[stem + end] = folder / f"{stem}{end}.jpg"
                figure.savefig(drawn[stem + end], dpi=100, pil_kwargs={"quality": 90 if stem == "figures-pictures" else 75})
            else:
                drawn[stem + end] = folder / f"{stem}{end}.png"
                figure.savefig(drawn[stem + end], dpi=100, bbox_inches="tight", metadata={"Software": None})
            plt.close(figure)
        for end, text in made.items():
            write(folder / (stem + end + ("" if "." in end else ".md")), text)
            texts[stem + end] = text
    maps = {file.stem.removeprefix("objects-map-"): numpy.load(file) for file in sorted(folder.glob("objects-map-*.npy"))}
    for name, figure in map_pictures(maps):
        stem = f"objects-{name}"
        drawn[stem] = folder / f"{stem}.png"
        figure.savefig(drawn[stem], dpi=100, metadata={"Software": None})
        plt.close(figure)
    return drawn, texts


def renewed(page, texts):
    """The page with the text of every record that it has a place for."""
    def place(match):
        text = texts.get(match.group(1))
        return match.group(0) if text is None else f"<!-- bench:{match.group(1)} -->\n\n{text.strip()}\n\n<!-- /bench -->"
    return re.sub(r"<!-- bench:([a-z-]+) -->\n.*?<!-- /bench -->", place, page, flags=re.S)


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        raise SystemExit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    drawn, texts = draw(folder)
    if not drawn and not texts:
        raise SystemExit(f"bench_charts: {folder} holds no record; measure with `kappamu-studies SUBJECT -o {folder}`")
    for page in map(pathlib.Path, sys.argv[2:]):
        text = page.read_text()
        write(page, renewed(text, texts))
        for name, picture in drawn.items():
            if f"images/{name}{picture.suffix}" in text:
                (page.parent / "images" / f"{name}{picture.suffix}").write_bytes(picture.read_bytes())
    print(f"{len(drawn)} pictures and {len(texts)} tables of {folder}")


if __name__ == "__main__":
    main()

"""Capture sessions, runs, scenes and pictures."""
from __future__ import annotations

import dataclasses
import functools
import json
import os
import pathlib
import tempfile

from . import _core, commands
from .errors import InputError
from .fitting import Fit
from .lazy import np
from .measurements import read_measurements
from .temporary import temporary_folder
from .volumes import read_image


def read_session(folder: str | os.PathLike) -> dict:
    """session.json of a capture session (docs/formats.md) as a dict, once all of its checks have passed.

    Raises:
        InputError: naming file and field.
    """
    _core.check_session(os.fspath(folder))
    return json.loads((pathlib.Path(folder) / "session.json").read_text())


def write_session(folder: str | os.PathLike, session: dict) -> None:
    """Writes `session`, a dict as read_session() returns it, to session.json of `folder`, where its frames lie.

    What fails the checks is not kept: session.json is then as it was. Raises InputError naming the field.
    """
    file = pathlib.Path(folder) / "session.json"
    former = file.read_bytes() if file.exists() else None
    file.parent.mkdir(parents=True, exist_ok=True)
    temporary = file.with_name("session.json.tmp")
    temporary.write_text(json.dumps(session, indent=1) + "\n")
    temporary.replace(file)
    try:
        _core.check_session(os.fspath(folder))
    except InputError:
        if former is None:
            file.unlink()
        else:
            file.write_bytes(former)
        raise


class Run:
    """A run folder: what `kappamu run` and its stages leave.

    Attributes:
        folder: path. record: run.json as a dict, with the stages that are done. fit: its Fit. measurements: its Measurements.
        report_page: path of report.html.
    """

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        if not (self.folder / "run.json").exists():
            raise InputError(f"{self.folder}: has no run.json; give the folder of a run")
        self.record = json.loads((self.folder / "run.json").read_text())
        self.report_page = self.folder / "report.html"

    @functools.cached_property
    def fit(self):
        return Fit(self.folder)

    @functools.cached_property
    def measurements(self):
        return read_measurements(self.folder)

    def __fspath__(self):
        return str(self.folder)


def run(input: str | os.PathLike, out: str | os.PathLike, **options) -> Run:
    """Does everything from a capture session, or from measurements, to volumes and a report; kappamu.commands.run().

    Args:
        input: folder with session.json or measurements.json.
        out: run folder; made if missing, and continued where it was.
        options: those of kappamu.commands.run(), a fit's among them.

    Returns:
        Run: `.fit.verdict` says whether to trust it.
    """
    commands.run(input, out, **options)
    return Run(out)


def read_run(folder: str | os.PathLike) -> Run:
    """The run in `folder`."""
    return Run(folder)


@dataclasses.dataclass
class Picture:
    """A rendered scene.

    Attributes:
        radiance: linear R, G, B per unit of irradiance, float32 [y][x][3].
        image: the same exposed and tone-mapped, uint16 codes 0 ... 255, [y][x][3].
        exitance: what leaves each triangle, float32 [3][sample].
        surface: position [mm], outward normal and area [mm²] of each triangle, float32 [sample][7].
        report: summary.json.
        folder: where the files lie.
    """

    radiance: np.ndarray
    image: np.ndarray
    exitance: np.ndarray
    surface: np.ndarray
    report: dict
    folder: object


def render(scene: str | os.PathLike | dict, out: str | os.PathLike | None = None, *, device: str | None = None,
           seed: int | None = None, progress=None) -> Picture:
    """Renders a scene: a file of format kappamu-scene, or a dict of the same content (docs/scene.md).

    Args:
        scene: path, or dict; files that a dict names are taken from the working folder.
        out: folder of the pictures; by itself a temporary one, removed with the Picture.
        device, seed, progress: as in forward().

    Returns:
        Picture: radiance, tone-mapped image, exitance of the triangles.

    Raises:
        InputError: naming what in the scene is wrong.
    """
    own = None
    if isinstance(scene, dict):
        handle, own = tempfile.mkstemp(suffix=".json", prefix="kappamu-scene-", dir=".")
        with os.fdopen(handle, "w") as file:
            json.dump(scene, file)
        scene = own
    try:
        with temporary_folder("kappamu-render-", wanted=out is None) as (temporary, keep_with):
            out = pathlib.Path(out or pathlib.Path(temporary) / "picture")
            report = commands.render(scene=scene, out=out, device=device, seed=seed, progress=progress)
            picture = Picture(read_image(out / "picture.exr"), read_image(out / "picture.png"), np.load(out / "exitance.npy"),
                              np.load(out / "surface.npy"), report, out)
            keep_with(picture)
            return picture
    except InputError as error:
        if own is None:
            raise
        raise InputError(str(error).replace(os.path.abspath(own), "scene"), error.key) from None
    finally:
        if own is not None:
            os.unlink(own)


def view(what, **options):
    """Opens the window of `kappamu view` on a scene file, a run, a Fit or a .vdb file; kappamu.commands.view() has the options."""
    return commands.view(what, **options)

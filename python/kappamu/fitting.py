"""A fit, and what it leaves: κ and μ with their standard deviations, the verdict and the report."""
from __future__ import annotations

import functools
import json
import os
import pathlib

from . import _core, commands
from .arrays import face_map, volume
from .errors import InputError, key_in
from .lazy import np
from .measurements import Measurements, write_measurements
from .progress import listener
from .temporary import temporary_folder
from .volumes import QUANTITIES


def _read_into(files):
    """The .npy files as one array, each read into its place."""
    with open(files[0], "rb") as file:
        np.lib.format.read_magic(file)
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    joined = np.empty((len(files), *shape), dtype)
    for place, name in zip(joined, files):
        with open(name, "rb") as file:
            np.lib.format.read_magic(file)
            if np.lib.format.read_array_header_1_0(file)[0] != shape or file.readinto(place) != place.nbytes:
                raise InputError(f"{name}: is not of the shape of {files[0]}, or is cut short")
    return joined


class Fit:
    """A finished fit. Arrays are read when they are asked for, and kept.

    Attributes of every channel: float32 [channel][z][y][x], units in `attrs`:
        kappa, mu [mm, 1/mm]; std_kappa, std_mu (one standard deviation of the mean over what the fit resolves);
        resolution_kappa, resolution_mu, correlation, sensitivity [1]. None where the fit did not estimate them.
    Others:
        prediction: float32 [channel][M][v][u] on the seen face.
        channels, voxel_mm, eta; folder: where the files lie; report: fit.json as a dict.
        verdict: the sentence that says whether to trust the fit; grade: "green", "amber", "red" or "unknown".
    """

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        if not (folder / "fit.json").exists() and (folder / "fit" / "fit.json").exists():
            folder = folder / "fit"
        if not (folder / "fit.json").exists():
            raise InputError(f"{folder}: has no fit.json; give the folder of a fit or of a run")
        self.folder = folder
        self.report = json.loads((folder / "fit.json").read_text())
        self.channels = [channel["name"] for channel in self.report["channels"]]
        self.voxel_mm, self.eta = self.report["voxel_mm"], self.report["eta"]

    @property
    def verdict(self) -> str:
        return self.report["verdict"]["sentence"]

    @property
    def grade(self) -> str:
        return self.report["verdict"]["grade"]

    @property
    def converged(self) -> bool:
        return self.report["status"] == "converged"

    @property
    def validation_E(self) -> float | None:
        """Error under validation patterns, Σ(L' − L)²/ΣL²; None without any."""
        return self.report.get("validation_E")

    @property
    def warnings(self):
        return self.report["warnings"]

    @property
    def metadata(self):
        return {"program": "kappamu fit", "device": self.report["device"]}

    def _volumes(self, name):
        if not (self.folder / "fit.json").exists():
            raise InputError(f"{self.folder}: is not there any more; give the fit a folder by `out`, or keep the Fit that made it")
        files = [self.folder / f"{name}_{channel}.npy" for channel in self.channels]
        if not all(file.exists() for file in files):
            return None
        return volume(_read_into(files), self.voxel_mm, *QUANTITIES[name], leading=[("channel", self.channels)])

    @functools.cached_property
    def prediction(self):
        seen = self._measured()["seen_face"]
        return face_map(np.load(self.folder / "prediction.npy"), seen, self.voxel_mm, "unit of the measurements", "prediction",
                        leading=("channel", "pattern"))

    def _measured(self):
        source = pathlib.Path(self.report["input"])
        for folder in (source, source / "measurements"):
            if (folder / "measurements.json").exists():
                return json.loads((folder / "measurements.json").read_text())
        raise InputError(f"{source}: the measurements of this fit are not there any more")

    def __repr__(self):
        return f"<kappamu.Fit {'x'.join(map(str, reversed(self.report['grid'])))} {', '.join(self.channels)}: {self.verdict}>"

    def __fspath__(self):
        return str(self.folder)


def _lazy(name):
    def read(self):
        return self._volumes(name)

    read.__doc__ = f"{QUANTITIES[name][1].capitalize()} [{QUANTITIES[name][0]}], float32 [channel][z][y][x]."
    return functools.cached_property(read)


for _name in QUANTITIES:
    _property = _lazy(_name)
    setattr(Fit, _name, _property)
    _property.__set_name__(Fit, _name)

OPTIONS = json.loads(_core.fit_options())  # every option of a fit by its key, with its default
del OPTIONS["continue_from"]


def _plain_option(value):
    """NumPy's numbers and arrays as JSON takes them."""
    return value.tolist() if hasattr(value, "tolist") else os.fspath(value) if hasattr(value, "__fspath__") else value


def fit(measurements: str | os.PathLike | Measurements | None = None, out: str | os.PathLike | None = None, *,
        validate: str | os.PathLike | Measurements | None = None, continue_from: str | os.PathLike | None = None,
        restart: bool = False, progress=None, **options) -> Fit:
    """Finds the volumes of κ and μ that explain surface measurements.

    Args:
        measurements: a folder with measurements.json, a run that `merge` filled, or Measurements, which are written to
            <out>_input. Not needed with continue_from.
        out: folder of the results, which the same call continues if it was killed; by itself a temporary one, removed with
            the Fit.
        validate: measurements of validation patterns, a folder or Measurements; by itself those beside the input.
        continue_from: folder of a finished fit or run to go on from, with its options where none are given here.
        restart: ignore checkpoints in `out`.
        progress: function of (stage, fraction, detail), or True for a bar of tqdm.
        options: every option of docs/reference/fit-options.md by its name, such as model="volume", channels=["G"],
            hold_out="none", regulariser="h1". kappamu.fit_options() has the defaults.

    Returns:
        Fit: `.verdict` says whether to trust it.

    Raises:
        InputError: with the key of the option at fault.
    """
    for name in options:
        if name not in OPTIONS:
            raise InputError(f"a fit has no option {name}; kappamu.fit_options() lists them", name)
    if measurements is None and continue_from is None:
        raise InputError("measurements are missing; give a folder, Measurements, or continue_from", "measurements")
    words = {name: _plain_option(value) for name, value in options.items()}
    if isinstance(words.get("channels"), str):
        words["channels"] = [words["channels"]]
    if isinstance(words.get("hold_out"), (int, list, tuple)):
        held = words["hold_out"]
        words["hold_out"] = ",".join(map(str, held)) if isinstance(held, (list, tuple)) else str(held)
    for name, value in words.items():
        try:
            json.dumps(value, allow_nan=False)
        except (TypeError, ValueError):
            raise InputError(f"{name} is {value!r}; options of a fit are finite numbers, texts and lists of them", name) from None

    def folder_of(given, name, place):
        if isinstance(given, Measurements):
            write_measurements(place / name, given)
            return os.fspath(place / name)
        if given is not None and not isinstance(given, (str, os.PathLike)):
            raise InputError(f"{name} must be a folder or kappamu.Measurements, not {type(given).__name__}", name)
        return None if given is None else os.fspath(given)

    try:
        with temporary_folder("kappamu-fit-", wanted=out is None) as (temporary, keep_with):
            place = pathlib.Path(temporary or f"{os.fspath(out).rstrip('/')}_input")
            found = Fit(_core.fit(folder_of(measurements, "measurements", place) or "", os.fspath(out or place / "fit"),
                                  folder_of(validate, "validate", place),
                                  None if continue_from is None else os.fspath(continue_from),
                                  bool(restart), json.dumps(words), listener(progress)))
            keep_with(found)
            return found
    except InputError as error:
        sentence, key = commands.ALL["fit"].reword(str(error))
        raise InputError(sentence, error.key or key or key_in(sentence, OPTIONS)) from None


def fit_options() -> dict:
    """Every option of a fit with its default; docs/reference/fit-options.md explains them."""
    return dict(OPTIONS)


def read_fit(folder: str | os.PathLike) -> Fit:
    """The finished fit in `folder`, of a fit or of a run."""
    return Fit(folder)

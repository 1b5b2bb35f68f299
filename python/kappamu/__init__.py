"""kappamu: from photographs of a translucent block to its diffusion coefficient κ [mm] and absorption coefficient μ [1/mm].

    import kappamu as km
    light = km.forward(kappa, mu, voxel_mm=0.25, irradiance=e)     # exitance of all faces
    fit = km.fit("measurements", model="auto")                    # a folder, or km.Measurements of your own arrays
    fit.kappa, fit.mu, fit.std_kappa, fit.verdict                  # [channel][z][y][x], units in attrs

Lengths are mm. Arrays are [z][y][x] in C order, x fastest; maps of a face are [v][u]. Bad input raises InputError with one
sentence and the key of the argument. docs/python.md.
"""
from . import commands
from .commands import (Answer, bench, calibrate, chart, doctor, edit, export, import_, map, merge, plan, report, score, simulate,
                       verify)
from .errors import InputError, KappamuWarning, NotConverged
from .fitting import Fit, fit, fit_options, read_fit
from .measurements import Measurements, read_measurements, write_measurements
from .operator import DiffusionOperator, Light
from .runs import Picture, Run, read_run, read_session, render, run, view, write_session
from .simulation import Exitance, forward, forward_methods
from .volumes import Volumes, read_image, read_volume, write_volume

__version__ = "0.1.0"

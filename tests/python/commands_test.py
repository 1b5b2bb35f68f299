"""Every command and option is a function and an argument; values, errors and progress go through."""
import inspect
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import numpy as np

import kappamu as km
from kappamu import commands, stubs

sys.path.insert(0, os.path.dirname(__file__))
import block

SOURCE = pathlib.Path(os.environ["KAPPAMU_SOURCE"])
PROGRAM = os.environ["KAPPAMU_PROGRAM"]


def help_of(*words):
    return subprocess.run([PROGRAM, *words, "--help"], capture_output=True, text=True, check=True).stdout


class EveryAbility(unittest.TestCase):
    def test_every_command_of_the_help_is_a_function(self):
        listed = set(re.findall(r"^  ([a-z]+) {2,}", help_of(), re.M))
        self.assertGreater(len(listed), 15)
        self.assertEqual(listed, set(commands.ALL))
        for name in listed:
            self.assertTrue(callable(getattr(commands, commands.python_name(name))), name)
            self.assertTrue(callable(getattr(km, commands.python_name(name))), name)

    def test_every_flag_of_the_help_is_an_argument(self):
        """Flags are read from the help that the program prints, not from the description that the functions are made of."""
        total = 0
        for name in set(commands.ALL) - {"bench"}:
            flags = set(re.findall(r"^  (?:-[a-z],)?(--[a-z][a-z0-9-]*)", help_of(name), re.M)) - {"--help"}
            known = {option["flag"] for option in commands.ALL[name].options.values()}
            self.assertEqual(flags - known, set(), name)
            arguments = inspect.signature(getattr(commands, commands.python_name(name))).parameters
            self.assertEqual(set(commands.ALL[name].options) - set(arguments), set(), name)
            total += len(flags)
        self.assertGreater(total, 100)

    def test_table_and_stubs_are_the_generated_ones(self):
        self.assertEqual((SOURCE / "docs/reference/python-names.md").read_text(), stubs.table(), "run scripts/python_names.sh")
        self.assertEqual((SOURCE / "python/kappamu/commands.pyi").read_text(), stubs.of_commands(), "run scripts/python_names.sh")

    def test_every_option_of_a_fit_is_an_argument_of_fit(self):
        described = {option for option in commands.ALL["fit"].options if option in km.fit_options()}
        self.assertGreater(len(described), 15)
        self.assertGreater(len(km.fit_options()), len(described))


class Calls(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_doctor_examines(self):
        found = commands.doctor(device="reference")
        self.assertEqual(found["solves_on"], "reference")
        self.assertTrue(found.ok)

    def test_plan_takes_lists_flags_and_numbers(self):
        found = commands.plan([20, 16, 6], 20, 1600, 1200, 1024, 768, self.folder / "plan", exposures=4, room_light=True)
        self.assertEqual(found["grid"], [40, 32, 12])
        self.assertEqual(len(found["exposures_s"]), 4)
        self.assertTrue((self.folder / "plan" / "session.json").exists())
        session = km.read_session(self.folder / "plan")
        self.assertEqual(session["sample"]["voxel_mm"], 0.5)

    def test_a_warning_is_pythons(self):
        with self.assertWarnsRegex(km.KappamuWarning, "whole number of voxels"):
            commands.plan([20.3, 16, 6], 20, 1600, 1200, 1024, 768, self.folder / "plan")

    def test_forward_by_files_equals_forward_by_arrays(self):
        kappa, mu = block.coefficients()
        e = block.patches()
        for name, array in (("k", kappa), ("m", mu), ("e", e)):
            np.save(self.folder / f"{name}.npy", array)
        found = commands.forward(self.folder / "k.npy", self.folder / "m.npy", self.folder / "out",
                                 irradiance=self.folder / "e.npy", voxel=0.5, point=[(1, 2, 1.5), (2, 2, 1, 3)], device="reference",
                                 fluence="npy")
        light = km.forward(self.folder / "k.npy", mu, voxel_mm=0.5, irradiance=e, points=[(1, 2, 1.5), (2, 2, 1, 3)],
                           device="reference", fluence=True)
        self.assertEqual(len(found["patterns"]), len(e) + 2)
        for face in ("z+", "x-"):
            np.testing.assert_allclose(np.load(self.folder / "out" / f"exitance_{face}.npy"), light[face], rtol=1e-6)
        np.testing.assert_allclose(np.load(self.folder / "out" / "fluence.npy"), light.fluence, rtol=1e-6)

    def test_an_error_names_the_argument_and_no_flag(self):
        calls = {"voxel": lambda: commands.forward("k", "m", self.folder, voxel=-1),
                 "lit_face": lambda: commands.forward("k", "m", self.folder, lit_face="top"),
                 "camera": lambda: commands.simulate(self.folder / "s", camera="wide"),
                 "lens": lambda: commands.calibrate(self.folder, self.folder / "r", lens="l.yml"),
                 "no_such": lambda: commands.doctor(no_such=1)}
        for key, call in calls.items():
            with self.subTest(key):
                with self.assertRaises((km.InputError, TypeError)) as caught:
                    call()
                self.assertNotIn("--", str(caught.exception))
                if isinstance(caught.exception, km.InputError):
                    self.assertEqual(caught.exception.key, key, caught.exception)

    def test_progress_is_heard_and_ends_the_work(self):
        heard = []

        def stop(stage, fraction, detail):
            heard.append((threading.current_thread(), stage, fraction))
            raise RuntimeError("enough")

        with self.assertRaisesRegex(RuntimeError, "enough"):
            commands.simulate(self.folder / "s", sample="tiny", device="reference", progress=stop)
        self.assertIs(heard[0][0], threading.main_thread())
        self.assertFalse((self.folder / "s" / "session" / "session.json").exists())

    def test_ctrl_c_cancels(self):
        # The same with a signal, while the work lasts.
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        begin = time.perf_counter()
        with self.assertRaises(KeyboardInterrupt):
            for n in range(100):
                commands.simulate(self.folder / f"s{n}", sample="demo", device="reference")
        timer.join()
        self.assertLess(time.perf_counter() - begin, 60)


if __name__ == "__main__":
    unittest.main()

"""What a notebook gets wrong: every mistake is an InputError with the argument's key, never a flag and never a type of C++."""
import dataclasses
import os
import signal
import sys
import tempfile
import unittest
import warnings

import numpy as np

import kappamu as km

sys.path.insert(0, os.path.dirname(__file__))
import block


class BadInput(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        former, tempfile.tempdir = tempfile.tempdir, self.folder.name
        self.addCleanup(setattr, tempfile, "tempdir", former)

    def assert_nothing_is_left(self):
        self.assertEqual(os.listdir(self.folder.name), [])

    def refused(self, key, call, **case):
        with self.subTest(key=key, **case), self.assertRaises(km.InputError) as caught:
            call(**case)
        self.assertEqual(caught.exception.key, key, caught.exception)
        self.assertNotIn("--", str(caught.exception))

    def test_of_forward(self):
        kappa, mu = block.coefficients()

        def forward(**case):
            km.forward(**{"kappa": kappa, "mu": mu, "voxel_mm": 0.5, "irradiance": block.patches(), "device": "reference", **case})

        nan = kappa.copy()
        nan[0, 0, 5] = np.nan
        for key, value in (("mu", mu[1:]), ("mu", -mu), ("kappa", kappa[0]), ("kappa", nan), ("kappa", kappa + 0j), ("kappa", "k.npy"),
                           ("kappa", kappa.astype(str)), ("voxel_mm", None), ("voxel_mm", "0.5"), ("voxel_mm", [0.5, 0.5, 0.5]),
                           ("voxel_mm", -1), ("voxel_mm", True), ("voxel_mm", float("inf")),
                           ("irradiance", block.patches()[:, 1:]), ("irradiance", None), ("irradiance", 1e-300 * block.patches()),
                           ("irradiance", np.ma.masked_less(block.patches(), 0.5)), ("kappa", np.ma.masked_less(kappa, np.median(kappa))), ("lit_face", "top"),
                           ("lit_face", None), ("eta", 13), ("eta", "glass"), ("tolerance", 0), ("tolerance", 10), ("tolerance", "tight"),
                           ("max_iterations", 0), ("max_iterations", 10.5), ("photons", -1), ("photons", 1e4), ("seed", 0.5),
                           ("device", 0), ("method", None), ("direction", (0, 1)), ("direction", (0, 0, -1)), ("points", (1, 2, 3)),
                           ("points", [(1, 2)]), ("points", [("a", 1, 1)]), ("progress", 5)):
            self.refused(key, forward, **{key: value})

    def test_of_measurements(self):
        _, _, good = block.measurements()
        for key, value in (("value", np.ma.masked_less(good.value, np.median(good.value))), ("variance", 1e-4), ("variance", good.variance[:3]), ("variance", 0 * good.variance),
                           ("mask", np.ones(good.value.shape[1:])), ("shape", (6, 10)), ("shape", "6x10x12"), ("voxel_mm", "a"),
                           ("eta", None), ("eta", 0.5), ("camera_mm", (1, 2, 3)), ("camera_mm", {"z+": (1, 2)}),
                           ("quantity", "reflectance"), ("seen_faces", ["z+", "z-"]), ("channels", "a/b")):
            self.refused(key, lambda **case: km.fit(dataclasses.replace(good, **case)), **{key: value})
        self.assert_nothing_is_left()

    def test_of_options_of_a_fit(self):
        _, _, good = block.measurements()
        for key, value in (("target_chi2", float("nan")), ("target_chi2", float("inf")), ("weight", {}),
                           ("validate", 3), ("progress", "yes")):
            self.refused(key, lambda **case: km.fit(good, **case), **{key: value})
        self.refused("measurements", lambda: km.fit(good.value))

    def test_labels_that_contradict_the_argument(self):
        kappa, mu = block.coefficients(6, 6, 6)  # any order of the axes has this shape
        light = block.patches(6, 6)

        def labelled(array, dims, units):
            return km.arrays.labelled(array, dims, units, "coefficient")

        def forward(**case):
            return km.forward(**{"kappa": kappa, "mu": mu, "voxel_mm": 0.5, "irradiance": light, "device": "reference", **case})

        forward(kappa=labelled(kappa, tuple("zyx"), "mm"), mu=labelled(mu, tuple("zyx"), "1/mm"))
        for key, value in (("kappa", labelled(kappa, tuple("xyz"), "mm")), ("kappa", labelled(kappa, tuple("zyx"), "m")),
                           ("mu", labelled(mu, tuple("zyx"), "1/cm")), ("irradiance", labelled(light, ("pattern", "x", "y"), "1"))):
            self.refused(key, forward, **{key: value})

    def test_of_a_scene_that_is_a_dict(self):
        with self.assertRaisesRegex(km.InputError, "^scene: version is missing"):
            km.render({"format": "kappamu-scene"})

    def test_of_an_operator_and_of_volumes(self):
        kappa, mu = block.coefficients()
        self.refused("shape", lambda: km.DiffusionOperator((6, 10), 0.5))
        self.refused("mu", lambda: km.DiffusionOperator(kappa.shape, 0.5, kappa))
        self.refused("volumes", lambda: km.write_volume("x.vdb", kappa))

    def test_an_answer_beyond_its_tolerance_is_warned_of(self):
        kappa, mu = block.coefficients()
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            light = km.forward(kappa, mu, voxel_mm=0.5, irradiance=block.patches(), device="reference", max_iterations=1)
        self.assertFalse(light.converged)
        self.assertTrue(any("tolerance was not met" in str(w.message) for w in heard))

    def test_an_interrupted_fit_leaves_no_temporary_folder(self):
        _, _, good = block.measurements()
        with self.assertRaises(KeyboardInterrupt):
            km.fit(good, model="volume", progress=lambda *words: os.kill(os.getpid(), signal.SIGINT))
        self.assert_nothing_is_left()


if __name__ == "__main__":
    unittest.main()

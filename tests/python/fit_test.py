"""A fit from arrays and from a folder, its result and its errors; volumes and measurements on disk."""
import json
import os
import pathlib
import pickle
import sys
import tempfile
import unittest

import numpy as np

import kappamu as km
from kappamu import _core

sys.path.insert(0, os.path.dirname(__file__))
import block


class AFit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.kappa, cls.mu, cls.measurements = block.measurements(seed=8)
        cls.heard = []
        cls.fit = km.fit(cls.measurements, model="volume", hold_out="none", progress=lambda *words: cls.heard.append(words))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_explains_the_data_and_finds_the_light_of_the_truth(self):
        channel = self.fit.report["channels"][0]
        self.assertLess(channel["chi2_per_value"], 1.5)
        # Light that the fit never saw, on the volumes found and on the true ones.
        e = np.zeros((1, 10, 12))
        e[0, 2:5, 6:11] = 1.0
        found, true = (np.asarray(km.forward(k, m, voxel_mm=0.5, irradiance=e, device="reference")["z+"])
                       for k, m in ((np.asarray(self.fit.kappa)[0], np.asarray(self.fit.mu)[0]), (self.kappa, self.mu)))
        self.assertLess(np.sum((found - true)**2) / np.sum(true**2), 1e-3)

    def test_has_labelled_arrays_of_one_shape(self):
        shape = (1, 6, 10, 12)
        for name, units in (("kappa", "mm"), ("mu", "1/mm"), ("std_kappa", "mm"), ("std_mu", "1/mm"), ("resolution_mu", "1")):
            array = getattr(self.fit, name)
            self.assertEqual((array.shape, array.attrs["units"]), (shape, units), name)
            self.assertEqual(tuple(array.dims), ("channel", "z", "y", "x"))
        self.assertTrue((np.asarray(self.fit.std_kappa) > 0).all())
        self.assertEqual(self.fit.prediction.shape[:2], (1, 10))

    def test_is_what_its_files_are(self):
        again = km.read_fit(self.fit.folder)
        self.assertEqual(again.verdict, self.fit.verdict)
        stored = km.read_volume(self.fit.folder)
        np.testing.assert_array_equal(np.asarray(stored.kappa, np.float32), np.asarray(self.fit.kappa))
        self.assertEqual(stored.voxel_mm, 0.5)

    def test_arrays_are_pickled_with_their_labels(self):
        back = pickle.loads(pickle.dumps(self.fit.kappa))
        np.testing.assert_array_equal(np.asarray(back), np.asarray(self.fit.kappa))
        self.assertEqual((tuple(back.dims), back.attrs["units"]), (("channel", "z", "y", "x"), "mm"))
        self.assertNotEqual(tuple(back.T.dims), tuple(back.dims))  # a transpose does not keep the order of its axes

    def test_says_that_its_files_are_gone(self):
        copied = pickle.loads(pickle.dumps(km.fit(self.measurements, model="homogeneous", hold_out="none")))
        with self.assertRaisesRegex(km.InputError, "not there any more; give the fit a folder by `out`"):
            copied.kappa

    def test_told_of_its_progress(self):
        stages = {stage for stage, _, _ in self.heard}
        self.assertTrue(any(stage.startswith("fit") for stage in stages), stages)
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction, _ in self.heard))

    def test_exports_and_reads_every_format(self):
        folder = pathlib.Path(self.folder.name)
        for name, format in (("v.vdb", None), ("v.vti", None), ("mitsuba", "vol"), ("arrays", "npy")):
            files = km.write_volume(folder / name, self.fit, format)
            self.assertTrue(all(pathlib.Path(f).exists() for f in files), files)
        for name in ("v.vdb", "arrays"):
            back = km.read_volume(folder / name)
            np.testing.assert_array_equal(np.asarray(back.mu, np.float32), np.asarray(self.fit.mu))
            np.testing.assert_array_equal(np.asarray(back.std_mu, np.float32), np.asarray(self.fit.std_mu))
        files = km.export(self.fit, folder / "export", format=["vti", "pbrt"])["files"]
        self.assertEqual(len(files), 2)

    def test_a_read_volume_of_one_channel_is_not_copied_again(self):
        found = _core.read_volume(str(self.fit.folder), 10**8)
        joined = km.volumes._joined(found["kappa"], 0.5, ["grey"], "kappa")
        self.assertTrue(np.shares_memory(np.asarray(joined), found["kappa"][0]))

    def test_goes_on_from_a_finished_fit(self):
        out = pathlib.Path(self.folder.name) / "again"
        again = km.fit(continue_from=self.fit.folder, out=out, target_chi2=0.9)
        self.assertEqual(json.loads((out / "fit.json").read_text())["options"]["target_chi2"], 0.9)
        self.assertEqual(again.report["options"]["model"], "volume")

    def test_measurements_return_as_they_were(self):
        folder = pathlib.Path(self.folder.name) / "measurements"
        km.write_measurements(folder, self.measurements)
        back = km.read_measurements(folder)
        np.testing.assert_array_equal(back.value[0], self.measurements.value.astype(np.float32))
        self.assertEqual((back.shape, back.channels, back.lit_face), ((6, 10, 12), ["grey"], "z-"))


class Refusals(unittest.TestCase):
    def test_name_the_option(self):
        _, _, measurements = block.measurements(noise=0.01)
        for key, options in (("model", {"model": "cubic"}), ("target_chi2", {"target_chi2": -1.0}), ("weight", {"weight": "much"}),
                             ("no_such", {"no_such": 1}), ("stage_steps", {"stage_steps": 0}), ("batch", {"batch": 2.5})):
            with self.subTest(key), self.assertRaises(km.InputError) as caught:
                km.fit(measurements, **options)
            self.assertEqual(caught.exception.key, key, caught.exception)
            self.assertNotIn("--", str(caught.exception))

    def test_name_the_field_of_measurements(self):
        _, _, m = block.measurements()
        for key, change in (("irradiance", {"irradiance": m.irradiance[:, 1:]}), ("value", {"value": m.value[:3], "variance": m.value[:3]}),
                            ("lit_face", {"lit_face": "below"})):
            with self.subTest(key), self.assertRaises(km.InputError) as caught:
                km.fit(km.measurements.dataclasses.replace(m, **change))
            self.assertEqual(caught.exception.key, key, caught.exception)

    def test_of_volumes(self):
        kappa, mu = block.coefficients()
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(km.InputError, "kappa"):
                km.write_volume(f"{folder}/v.vdb", km.Volumes(-kappa, mu, 0.5))
            with self.assertRaises(km.InputError) as caught:
                km.write_volume(f"{folder}/v.png", km.Volumes(kappa, mu, 0.5))
            self.assertEqual(caught.exception.key, "format")
            with self.assertRaisesRegex(km.InputError, "nowhere"):
                km.read_volume(f"{folder}/nowhere.vdb")


if __name__ == "__main__":
    unittest.main()

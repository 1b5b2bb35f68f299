"""Laws of DiffusionOperator: solve and apply are inverse, the operator is its own adjoint, derivatives agree with differences,
and arrays that lie right are not copied."""
import importlib.util
import multiprocessing
import os
import subprocess
import sys
import threading
import time
import tracemalloc
import unittest

import numpy as np

import kappamu as km
from kappamu import _core

sys.path.insert(0, os.path.dirname(__file__))
import block

TIGHT = {"device": "reference", "tolerance": 1e-12}  # double precision: what remains is rounding


def operator(seed=3, **options):
    kappa, mu = block.coefficients(seed=seed)
    return km.DiffusionOperator(kappa.shape, 0.5, kappa, mu, **{**TIGHT, **options}), kappa, mu


class Operator(unittest.TestCase):
    def test_solve_inverts_apply(self):
        op, kappa, _ = operator()
        phi = np.random.default_rng(5).standard_normal((2, *kappa.shape))
        np.testing.assert_allclose(op.solve(op.apply(phi)), phi, atol=1e-9)

    def test_is_its_own_adjoint(self):
        op, kappa, _ = operator()
        a, b = np.random.default_rng(6).standard_normal((2, *kappa.shape))
        self.assertAlmostEqual(np.sum(a * op.apply(b)[0]), np.sum(b * op.apply(a)[0]), places=10)

    def test_exitance_and_its_transpose_agree(self):
        op, kappa, _ = operator()
        random = np.random.default_rng(7)
        for face, shape in (("z+", (10, 12)), ("y-", (6, 12)), ("x+", (6, 10))):
            phi, psi = random.standard_normal((1, *kappa.shape)), random.standard_normal((1, *shape))
            left, right = np.sum(op.exitance(phi, face) * psi), np.sum(phi * op.exitance_transposed(psi, face))
            self.assertAlmostEqual(left, right, places=10)

    def test_light_is_a_solve_of_its_load(self):
        op, _, _ = operator()
        e = block.patches()
        np.testing.assert_allclose(op.illuminate(e).exitance("z+"), op.exitance(op.solve(op.load(e)), "z+"), rtol=1e-9)

    def test_agrees_with_forward(self):
        op, kappa, mu = operator()
        e = block.patches()
        light = km.forward(kappa, mu, voxel_mm=0.5, irradiance=e, device="reference", tolerance=1e-12)
        for face in ("z+", "z-", "x-"):
            np.testing.assert_allclose(op.illuminate(e).exitance(face), light[face], rtol=1e-8, atol=1e-15)

    def check_gradient(self, face, zero_mu=False, **options):
        """The Taylor remainder of J falls as the square of the step, which no wrong gradient does."""
        op, kappa, mu = operator(**options)
        if zero_mu:
            mu = mu.copy()
            mu[2:4] = 0.0
        random = np.random.default_rng(11)
        lit = {"z": (10, 12), "y": (6, 12), "x": (6, 10)}[op.lit_face[0]]
        e = random.uniform(0.5, 1.5, (3, *lit))
        op.set_medium(kappa, mu)
        light = op.illuminate(e)
        weights = random.standard_normal(light.exitance(face).shape)
        by_kappa, by_mu, by_light = light.gradient(weights, face)
        steps = 0.1 * kappa * random.standard_normal(kappa.shape), 0.01 * random.uniform(0, 1, mu.shape), 0.1 * random.standard_normal(e.shape)
        slope = sum(np.sum(g * s) for g, s in zip((by_kappa, by_mu, by_light), steps))
        start = np.sum(weights * light.exitance(face))
        self.assertGreater(abs(slope), 1e-6 * abs(start))

        def remainder(t):
            op.set_medium(kappa + t * steps[0], mu + t * steps[1])
            return abs(np.sum(weights * op.illuminate(e + t * steps[2]).exitance(face)) - start - t * slope)

        coarse, fine = remainder(1e-2), remainder(1e-3)
        order = np.log10(coarse / fine)
        self.assertGreater(order, 1.9, f"remainders {coarse:.2e}, {fine:.2e}")

    def test_gradient_by_first_collisions(self):
        self.check_gradient("z+")

    def test_gradient_on_the_lit_face(self):
        self.check_gradient("z-")

    def test_gradient_of_diffuse_entry(self):
        for face in ("z+", "z-", "y+"):
            with self.subTest(face):
                self.check_gradient(face, source="boundary")

    def test_gradient_lit_from_the_side(self):
        self.check_gradient("x+", lit_face="x-")
        self.check_gradient("y-", lit_face="y+", sides="mirror")

    def test_gradient_where_nothing_absorbs(self):
        self.check_gradient("z+", zero_mu=True)

    def test_light_of_another_medium_is_refused(self):
        op, kappa, mu = operator()
        light = op.illuminate(block.patches())
        op.set_medium(2 * kappa, mu)
        with self.assertRaisesRegex(km.InputError, "another medium"):
            light.exitance()

    def test_what_the_caller_changes_afterwards_changes_nothing(self):
        op, kappa, mu = operator()
        k, m, e = kappa.copy(), mu.copy(), block.patches()
        weights = np.random.default_rng(4).standard_normal(e.shape)
        op.set_medium(k, m)
        light = op.illuminate(e)
        before = light.exitance("z-"), *light.gradient(weights, "z-")
        for array in (k, m, e):
            array *= 3
        for a, b in zip(before, (light.exitance("z-"), *light.gradient(weights, "z-"))):
            np.testing.assert_array_equal(a, b)

    def test_loads_are_linear_in_the_light_on_every_device(self):
        e = np.random.default_rng(9).standard_normal((2, 10, 12))  # a difference of lights
        for device in ("reference", "auto"):
            op, _, _ = operator(device=device, tolerance=1e-6)
            with self.subTest(op.backend):
                whole, parts = op.load(e), op.load(np.maximum(e, 0)) - op.load(np.maximum(-e, 0))
                np.testing.assert_allclose(whole, parts, atol=1e-6 * np.abs(whole).max())
                self.assertGreater(np.abs(op.load(-np.abs(e))).max(), 0)

    def test_refuses_what_no_float_holds(self):
        kappa, mu = block.coefficients()
        e, hidden = block.patches(), np.ma.masked_array(kappa, kappa > np.median(kappa))
        for device in ("reference", "auto"):
            op = km.DiffusionOperator(kappa.shape, 0.5, kappa, mu, device=device)
            load = op.load(e)
            for key, call in (("irradiance", lambda: op.illuminate(np.nan * e)), ("irradiance", lambda: op.load(np.inf * np.ones_like(e))),
                              ("irradiance", lambda: op.illuminate(1e-300 * e)), ("irradiance", lambda: op.illuminate(1e30 * e)),
                              ("irradiance", lambda: op.illuminate(e[:0])), ("load", lambda: op.solve(load[:0])),
                              ("kappa", lambda: op.set_medium(1e30 * kappa, mu)), ("kappa", lambda: op.set_medium(1e-30 * kappa, mu)),
                              ("mu", lambda: op.set_medium(kappa, 1e30 * mu)), ("mu", lambda: op.set_medium(kappa, None)),
                              ("kappa", lambda: op.set_medium(hidden, mu)), ("face", lambda: op.exitance(load, None))):
                with self.subTest(key, device=device), self.assertRaises(km.InputError) as caught:
                    call()
                self.assertEqual(caught.exception.key, key, caught.exception)
            np.testing.assert_array_equal(op.load(e), load)  # what was refused has changed nothing

    def test_refuses_its_settings_by_name(self):
        for key, value in (("shape", (8, 16, 16.7)), ("shape", ("8", "16", "16")), ("shape", None), ("shape", (0, 4, 4)),
                           ("voxel_mm", 0), ("voxel_mm", "0.5"), ("voxel_mm", 1e-300), ("voxel_mm", float("nan")), ("eta", "a"),
                           ("eta", 0.5), ("eta", float("nan")), ("tolerance", 10), ("tolerance", "x"), ("tolerance", float("nan")),
                           ("max_iterations", 1.5), ("device", 3), ("lit_face", 3), ("precision", "half")):
            with self.subTest(key, value=value), self.assertRaises(km.InputError) as caught:
                km.DiffusionOperator(**{"shape": (4, 4, 4), "voxel_mm": 0.5, key: value})
            self.assertEqual(caught.exception.key, key, caught.exception)

    def test_refuses_by_name(self):
        op, kappa, mu = operator()
        for key, call in (("kappa", lambda: op.set_medium(kappa[1:], mu)), ("load", lambda: op.solve(kappa[0])),
                          ("face", lambda: op.exitance(kappa, "up")), ("irradiance", lambda: op.load(kappa[0, 1:])),
                          ("lit_face", lambda: km.DiffusionOperator(kappa.shape, 0.5, lit_face="top"))):
            with self.subTest(key), self.assertRaises(km.InputError) as caught:
                call()
            self.assertEqual(caught.exception.key, key)

    def test_says_that_it_has_not_converged(self):
        op, kappa, mu = operator(max_iterations=1)
        with self.assertRaises(km.NotConverged):
            op.illuminate(block.patches())


class Copies(unittest.TestCase):
    def test_only_what_lies_wrong_is_copied(self):
        op, kappa, mu = operator()
        load = op.load(block.patches())
        own = 2 * kappa.nbytes  # the operator's copy of its medium
        for arrays, expected in (((kappa, mu), own), ((kappa.astype(np.float32), mu), own + kappa.nbytes),
                                 ((kappa[::-1], mu), own + kappa.nbytes)):
            before = _core.copied_bytes()
            op.set_medium(*arrays)
            self.assertEqual(_core.copied_bytes() - before, expected)
        before = _core.copied_bytes()
        op.solve(load)
        self.assertEqual(_core.copied_bytes(), before)

    def test_solve_allocates_its_answer_alone(self):
        op, _, _ = operator()
        load = op.load(block.patches())
        tracemalloc.start()
        op.solve(load)
        phi = op.solve(load)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        # Two answers are alive while the second is assigned; nothing else of that size.
        self.assertLess(peak, 1.2 * phi.nbytes + 100_000)

    def test_answers_own_the_memory_they_were_computed_in(self):
        kappa, mu = block.coefficients()
        light = km.forward(kappa, mu, voxel_mm=0.5, irradiance=block.patches(), device="reference")
        array = np.asarray(light["z+"])
        self.assertIsNotNone(array.base)
        self.assertTrue(array.flags.c_contiguous and array.flags.writeable)


class OtherThreads(unittest.TestCase):
    def test_they_run_while_a_solve_works(self):
        shape = (24, 48, 48)
        op = km.DiffusionOperator(shape, 0.5, np.full(shape, 0.4), np.full(shape, 0.01), **TIGHT)
        ticks, over = [], threading.Event()

        def tick():
            while not over.is_set():
                ticks.append(time.perf_counter())
                time.sleep(0.002)

        thread = threading.Thread(target=tick)
        thread.start()
        begin = time.perf_counter()
        op.illuminate(np.ones((4, 48, 48)))
        end = time.perf_counter()
        over.set()
        thread.join()
        during = [t for t in ticks if begin < t < end]
        self.assertGreater(end - begin, 0.05)
        self.assertGreater(len(during), 10, f"in {end - begin:.2f} s")


class TheEnd(unittest.TestCase):
    def test_waits_for_calls_of_other_threads(self):
        program = ("import threading, time, numpy as np, kappamu as km\n"
                   "class Slow:\n"
                   "    def __del__(self, sleep=time.sleep):\n"
                   "        sleep(1)\n"
                   "slow, begun, ones = Slow(), threading.Event(), np.ones((16, 32, 32))\n"
                   "def work():\n"
                   "    op = km.DiffusionOperator(ones.shape, 0.5, 0.4 * ones, 0.01 * ones, device='reference')\n"
                   "    while True:\n"
                   "        begun.set()\n"
                   "        {call}\n"
                   "threading.Thread(target=work, daemon=True).start()\n"
                   "begun.wait()\n"
                   "time.sleep(0.3)\n")
        for call in ("op.illuminate(ones)", "km.forward(0.4 * ones, 0.01 * ones, voxel_mm=0.5, irradiance=ones, device='reference')"):
            with self.subTest(call):
                ended = subprocess.run([sys.executable, "-W", "ignore", "-c", program.format(call=call)], capture_output=True, text=True,
                                       timeout=120, check=False)
                self.assertEqual(ended.returncode, 0, ended.stderr)


class OtherProcesses(unittest.TestCase):
    def test_a_fork_is_told_what_it_lacks_and_does_not_wait(self):
        op, _, _ = operator(device="auto", tolerance=1e-6)
        if op.backend == "reference":
            self.skipTest("there is no OpenCL device")
        light = op.illuminate(block.patches())
        fork = multiprocessing.get_context("fork")
        for call in (light.fluence, lambda: op.illuminate(block.patches()), lambda: operator(device="auto", tolerance=1e-6)):
            answers = fork.SimpleQueue()

            def child():
                try:
                    call()
                    answers.put("answered")
                except BaseException as error:
                    answers.put(f"{type(error).__name__}: {error}")

            process = fork.Process(target=child)
            process.start()
            process.join(60)
            if process.is_alive():
                process.kill()
                self.fail("the fork waits for ever")
            self.assertRegex(answers.get(), "InputError: this process was forked .*'spawn'")


class Optimisers(unittest.TestCase):
    @unittest.skipUnless(importlib.util.find_spec("torch"), "PyTorch is not installed")
    def test_gradcheck_of_pytorch(self):
        import torch

        import kappamu.torch

        kappa, mu = block.coefficients(3, 4, 5)
        op = km.DiffusionOperator(kappa.shape, 0.5, **TIGHT)
        inputs = [torch.tensor(a, dtype=torch.float64, requires_grad=True)
                  for a in (kappa, mu, np.random.default_rng(2).uniform(0.5, 1.5, (2, 4, 5)))]
        self.assertTrue(torch.autograd.gradcheck(lambda k, m, e: kappamu.torch.exitance(op, k, m, e), inputs, eps=1e-5, atol=1e-8))

    @unittest.skipUnless(importlib.util.find_spec("jax"), "JAX is not installed")
    def test_check_grads_of_jax(self):
        import jax
        from jax.test_util import check_grads

        import kappamu.jax

        jax.config.update("jax_enable_x64", True)
        kappa, mu = block.coefficients(3, 4, 5)
        op = km.DiffusionOperator(kappa.shape, 0.5, **TIGHT)
        e = np.random.default_rng(2).uniform(0.5, 1.5, (2, 4, 5))
        check_grads(kappamu.jax.exitance(op), (kappa, mu, e), order=1, modes=["rev"], eps=1e-5)


if __name__ == "__main__":
    unittest.main()

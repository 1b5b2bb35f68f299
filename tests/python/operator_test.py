"""Laws of DiffusionOperator: solve and apply are inverse, the operator is its own adjoint, derivatives agree with differences,
and arrays that lie right are not copied."""
import importlib.util
import os
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
        for arrays, expected in (((kappa, mu), 0), ((kappa.astype(np.float32), mu), kappa.nbytes),
                                 ((kappa[::-1], mu), kappa.nbytes)):
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

"""Densities of directions: formulas, integrals, and chi-square tests of what is drawn."""
import math
import unittest

import numpy as np

import lumisweep as ls
from support import STRATEGIES, ball_transfer_function, ball_volume, chi_square_p, sidak, texel_indices

SPHERE, EPSILON, N = 4 * math.pi, 0.1, 32
POSITIONS = [(1.0, -3.0, 0.0), (-20.0, -25.0, -30.0), (13.0, 19.0, 11.0), (500.0, 0.0, 0.0)]


class Densities(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rng = np.random.default_rng(6)
        cls.volume = ball_volume()
        cls.radiance = rng.gamma(0.5, 1.0, (N, N, 3)).astype(np.float32)
        cls.radiance[3:9, 10:12] = 0.0  # no light: never drawn where the light is followed
        cls.radiance[20, 7] = 200.0
        cls.environment = ls.Environment.from_octahedral(cls.radiance)
        cls.visibility = ls.sweep_visibility(cls.volume, ball_transfer_function())
        cls.samplers = {strategy: ls.DirectionSampler(strategy, cls.volume, cls.environment, cls.visibility, epsilon=EPSILON)
                        for strategy in STRATEGIES}

    def test_formulas(self):
        """The papers' densities, at a cell's centre, where no other cell takes part."""
        k, j, i = 3, 2, 4
        position = ls.cell_centres(self.volume)[k, j, i]
        light = self.radiance @ np.array((0.2126, 0.7152, 0.0722))
        n = self.visibility.directions
        coarse_light = light.reshape(n, N // n, n, N // n).mean(axis=(1, 3))
        visible = self.visibility.values[:, :, k, j, i] / 255 + EPSILON

        def fine(texels):
            return np.repeat(np.repeat(texels, N // n, axis=0), N // n, axis=1)

        product = visible * coarse_light
        expected = {"uniform": np.ones((N, N)), "environment": light / light.mean(), "visibility": fine(visible / visible.mean()),
                    "combined": fine(product / product.mean()), "two-step": fine(product / product.mean() / coarse_light) * light}
        expected["auto"] = expected["two-step"]
        for strategy, sampler in self.samplers.items():
            with self.subTest(strategy):
                np.testing.assert_allclose(sampler.pdf_map(position), expected[strategy] / SPHERE, rtol=2e-5, atol=1e-12)
                self.assertEqual(sampler.strategy, "two-step" if strategy == "auto" else strategy)

    def test_integrals(self):
        for strategy, sampler in self.samplers.items():
            for position in POSITIONS:
                with self.subTest(strategy, position=position):
                    density = sampler.pdf_map(position)
                    self.assertGreaterEqual(density.min(), 0.0)
                    self.assertAlmostEqual(float(density.mean()) * SPHERE, 1.0, places=5)

    def test_between_cells_it_is_the_mixture(self):
        centres = ls.cell_centres(self.volume)
        a, b = centres[3, 2, 3], centres[3, 2, 4]
        visibility = self.samplers["visibility"]
        visible = self.visibility.values[:, :, 3, 2, 3:5].astype(float).mean(axis=(0, 1)) / 255 + EPSILON
        for part in (0.25, 0.5):
            weights = np.array((1 - part, part)) * visible
            expected = (weights[0] * visibility.pdf_map(a, 8) + weights[1] * visibility.pdf_map(b, 8)) / weights.sum()
            np.testing.assert_allclose(visibility.pdf_map(a + part * (b - a), 8), expected, rtol=1e-4)

    def test_maps_are_densities_at_texel_centres(self):
        for strategy, sampler in self.samplers.items():
            for n in (8, N, 64):
                with self.subTest(strategy, n=n):
                    found = sampler.pdf_map(POSITIONS[0], n)
                    self.assertEqual(found.shape, (n, n))
                    np.testing.assert_allclose(found, sampler.pdf(POSITIONS[0], ls.octahedral_directions(n)), rtol=1e-6)

    def test_many_positions_at_once(self):
        for strategy, sampler in self.samplers.items():
            with self.subTest(strategy):
                directions = ls.octahedral_directions(4)
                found = sampler.pdf(np.array(POSITIONS)[:, None, None, :], directions)
                self.assertEqual(found.shape, (len(POSITIONS), 4, 4))
                for position, each in zip(POSITIONS, found):
                    np.testing.assert_allclose(each, sampler.pdf(position, directions), rtol=1e-6)

    def test_samples_have_the_density_that_they_come_with(self):
        numbers = np.random.default_rng(7).random((50, 200, 3))
        for strategy, sampler in self.samplers.items():
            with self.subTest(strategy):
                directions, pdf = sampler.sample(POSITIONS[0], numbers)
                self.assertEqual((directions.shape, pdf.shape), ((50, 200, 3), (50, 200)))
                np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0, atol=1e-5)
                self.assertGreater(pdf.min(), 0.0)
                # A direction on a texel's edge may round to its neighbour: rarely.
                same = np.isclose(sampler.pdf(POSITIONS[0], directions), pdf, rtol=1e-4)
                self.assertGreater(same.mean(), 0.999)

    def test_chi_square(self):
        count = 60000
        rng = np.random.default_rng(8)
        level = sidak(0.01, len(self.samplers) * 2)
        for strategy, sampler in self.samplers.items():
            for position in POSITIONS[:2]:
                with self.subTest(strategy, position=position):
                    directions, _ = sampler.sample(position, rng.random((count, 3)))
                    found = np.zeros((N, N))
                    np.add.at(found, texel_indices(directions, N), 1)
                    expected = sampler.pdf_map(position) * SPHERE / N ** 2 * count
                    self.assertLessEqual(found[expected == 0].sum(), 2)  # on an edge, as above
                    self.assertGreater(self.p_value(found, expected), level)
                    # Were it another density, it would be found: that of the next position.
                    if strategy not in ("uniform", "environment"):
                        other = sampler.pdf_map(POSITIONS[2]) * SPHERE / N ** 2 * count
                        self.assertLess(self.p_value(found, other), 1e-6)

    @staticmethod
    def p_value(found, expected):
        """Texels of less than five expected make one class."""
        few = expected < 5
        found = np.append(found[~few], found[few].sum())
        expected = np.append(expected[~few], expected[few].sum())
        kept = expected > 0
        statistic = ((found - expected)[kept] ** 2 / expected[kept]).sum()
        return chi_square_p(statistic, kept.sum() - 1)

    def test_expectation_of_the_estimate(self):
        """The mean of L / p is the light's integral, whatever the strategy."""
        numbers = np.random.default_rng(9).random((40000, 3))
        expected = self.radiance.mean(axis=(0, 1), dtype=float) * SPHERE
        for strategy, sampler in self.samplers.items():
            with self.subTest(strategy):
                directions, pdf = sampler.sample(POSITIONS[0], numbers)
                estimates = self.environment(directions) / pdf[:, None]
                error = estimates.std(axis=0) / math.sqrt(len(numbers))
                self.assertLess(np.abs((estimates.mean(axis=0) - expected) / error).max(), 4.5)


class Making(unittest.TestCase):
    def test_visibility_where_it_is_needed(self):
        volume, light = ball_volume(), ls.Environment.constant()
        self.assertAlmostEqual(float(ls.DirectionSampler("uniform", volume, light).pdf((0, 0, 0), (0, 0, 1))), 1 / SPHERE)
        ls.DirectionSampler("environment", volume, light)
        for strategy in ("visibility", "combined", "two-step", "auto"):
            with self.subTest(strategy), self.assertRaisesRegex(ls.Error, "visibility"):
                ls.DirectionSampler(strategy, volume, light)
        with self.assertRaises((ls.Error, ValueError)):
            ls.DirectionSampler("best", volume, light)

    def test_impossible_numbers(self):
        sampler = ls.DirectionSampler("visibility", ball_volume(), ls.Environment.constant(),
                                      ls.sweep_visibility(ball_volume(), ball_transfer_function()))
        up = (0.0, 0.0, 1.0)
        for call in (lambda: sampler.pdf((math.nan, 0.0, 0.0), up), lambda: sampler.pdf((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
                     lambda: sampler.pdf((0.0, 0.0), up), lambda: sampler.pdf_map((0.0, 0.0, math.nan)),
                     lambda: sampler.pdf_map((0.0, 0.0, 0.0), 0), lambda: sampler.sample((math.nan, 0.0, 0.0), (0.5, 0.5, 0.5)),
                     lambda: sampler.sample((0.0, 0.0, 0.0), (1.0, 0.5, 0.5)),
                     lambda: sampler.sample((0.0, 0.0, 0.0), (0.5, 0.5))):
            with self.assertRaises(ls.Error):
                call()

    def test_from_a_session(self):
        volume, function, light = ball_volume(), ball_transfer_function(), ls.Environment.sky(resolution=64)
        session = ls.Session(volume, function, light, image_settings=ls.ImageSettings(width=8, height=8))
        session.prepare()
        own = ls.DirectionSampler("two-step", volume, light, ls.sweep_visibility(volume, function))
        np.testing.assert_array_equal(session.sampler().pdf_map(POSITIONS[0]), own.pdf_map(POSITIONS[0]))
        self.assertEqual(session.sampler("combined").strategy, "combined")


if __name__ == "__main__":
    unittest.main()

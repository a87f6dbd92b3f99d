"""No strategy and no visibility grid moves the image's mean: block means agree within their standard errors, at fixed seeds."""
import unittest

import numpy as np

import lumisweep as ls
from support import STRATEGIES, ball_session, normal_p, sidak

SIDE, BLOCK, SAMPLES = 32, 8, 128


def block_means(image):
    """Mean luminance of blocks and their variances."""
    def blocks(values):
        return values.astype(float).reshape(SIDE // BLOCK, BLOCK, SIDE // BLOCK, BLOCK).mean(axis=(1, 3)).ravel()

    weights = np.array((0.2126, 0.7152, 0.0722))
    # Channels of a path go together: the variance of their weighted sum is at most this.
    deviation = np.sqrt(image.variance) @ weights
    return blocks(image.radiance @ weights), blocks(deviation ** 2) / BLOCK ** 2


class EqualMeans(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # Independent numbers, as the variances of stratified ones are only estimated from above.
        cls.reference = block_means(cls.session(strategy="environment", seed=1).render(samples=4 * SAMPLES))

    @staticmethod
    def session(**settings):
        return ball_session(width=SIDE, height=SIDE, render_settings=ls.RenderSettings(random_numbers="independent", **settings))

    def expect_equal(self, image, comparisons):
        mean, variance = block_means(image)
        expected, expected_variance = self.reference
        lit = expected > 0
        z = (mean - expected)[lit] / np.sqrt(variance + expected_variance)[lit]
        level = sidak(0.01, comparisons * lit.sum())
        self.assertGreater(normal_p(np.abs(z).max()), level, z)
        middle = np.argmax(variance)
        self.assertLess(np.sqrt(variance[middle]), 0.03 * expected[middle])  # sharp enough to find a fault

    def test_strategies(self):
        for number, strategy in enumerate(STRATEGIES):
            with self.subTest(strategy):
                self.expect_equal(self.session(strategy=strategy, seed=100 + number).render(samples=SAMPLES), len(STRATEGIES))

    def test_poisoned_visibility(self):
        good = self.session(seed=7)
        plain = good.render(samples=SAMPLES)
        shape = good.visibility.values.shape
        rng = np.random.default_rng(4)
        poisons = {"zeros": np.zeros(shape), "ones": np.ones(shape), "noise": rng.random(shape),
                   "black and white": rng.integers(0, 2, shape).astype(float), "turned": 1.0 - good.visibility.values / 255.0}
        for name, values in poisons.items():
            with self.subTest(name):
                session = self.session(seed=7)
                session.prepare()
                session.visibility = ls.VisibilityGrid(values, session.volume, cell=4)
                np.testing.assert_array_equal(session.visibility.values, np.rint(values * 255))
                image = session.render(samples=SAMPLES)
                self.assertFalse(np.array_equal(image.radiance, plain.radiance), "the grid is not read at all")
                self.expect_equal(image, len(poisons))

    def test_a_bias_would_be_found(self):
        """What the comparison is worth: an image brighter by five per cent fails."""
        image = self.session(strategy="two-step", seed=3).render(samples=SAMPLES)
        brighter = ls.Image({name: image[name] * (1.05 if name in "RGB" else 1.0) for name in image.channels})
        with self.assertRaises(AssertionError):
            self.expect_equal(brighter, len(STRATEGIES))


if __name__ == "__main__":
    unittest.main()

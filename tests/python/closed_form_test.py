"""Images of homogeneous boxes against quadrature in NumPy: the equation of docs and papers, not the program's own code.

L(o, d) = ∫ T σ ρ [∫ V L_env / 4π dω] dt + T L_env(d), with T and V exponentials of distances.
"""
import math
import unittest

import numpy as np

import lumisweep as ls
from support import STRATEGIES, box_volume, distance_to_box, homogeneous, image_mean, sphere_directions

EXTINCTION, ALBEDO = 0.9, (1.0, 0.5, 0.25)


def needle(start, end):
    """A camera of which all pixels see the line from `start` to `end`."""
    start, end = np.array(start), np.array(end)
    return ls.Camera(position=tuple(start + 3 * (start - end)), target=tuple(end), vertical_fov_deg=1e-3)


def single_scattering(half, start, end, light=lambda directions: 1.0, steps=48):
    """Of albedo 1, along the line between two points of the surface; `light` of directions."""
    nodes, weights = np.polynomial.legendre.leggauss(steps)
    length = np.linalg.norm(end - start)
    directions = sphere_directions(160)
    lit = light(directions)
    total = 0.0
    for t, weight in zip((nodes + 1) * length / 2, weights * length / 2):
        p = start + (end - start) * t / length
        arriving = (np.exp(-EXTINCTION * distance_to_box(half, p, directions)) * lit).mean()
        total += weight * EXTINCTION * math.exp(-EXTINCTION * t) * arriving
    return total


class HomogeneousBox(unittest.TestCase):
    def setUp(self):
        self.volume, self.half = box_volume()
        self.start = self.half * (-1.0, 0.7, 0.2)
        self.end = self.half * (1.0, 0.4, 0.8)
        self.through = math.exp(-EXTINCTION * np.linalg.norm(self.end - self.start))

    def session(self, environment, show_environment=True, **settings):
        return ls.Session(self.volume, homogeneous(EXTINCTION, ALBEDO), environment, camera=needle(self.start, self.end),
                          image_settings=ls.ImageSettings(width=64, height=64, show_environment=show_environment),
                          render_settings=ls.RenderSettings(**settings))

    def expect(self, image, expected, largest_error=4e-3):
        mean, error = image_mean(image)
        for channel in range(3):
            self.assertLess(error[channel], largest_error * expected[channel])
            self.assertLess(abs(mean[channel] - expected[channel]), 4 * error[channel] + 1e-6, (mean, expected, error))

    def test_white_light(self):
        scattered = single_scattering(self.half, self.start, self.end)
        self.assertLess(scattered + self.through, 1.0)  # what single scattering loses
        image = self.session(ls.Environment.constant((1.0, 1.0, 1.0))).render(samples=64)
        self.expect(image, [rho * scattered + self.through for rho in ALBEDO])
        self.assertAlmostEqual(float(image.alpha.mean()), 1 - self.through, delta=2e-3)

    def test_every_strategy_under_light_from_one_side(self):
        """Lit from +X, −Y and above only, by one pixel of a map: an axis mirrored anywhere would show."""
        pixels = np.zeros((2, 4, 3))
        pixels[0, 2] = 8.0

        def light(directions):
            return np.all(directions * (1, -1, 1) > 0, axis=-1) * 8.0

        scattered = single_scattering(self.half, self.start, self.end, light)
        for mirror in ((-1, 1, 1), (1, -1, 1), (1, 1, -1)):
            mirrored = single_scattering(self.half, self.start, self.end, lambda d, m=mirror: light(d * m), steps=16)
            self.assertGreater(abs(mirrored / scattered - 1), 0.05)
        for strategy in STRATEGIES:
            with self.subTest(strategy):
                session = self.session(ls.Environment.from_latlong(pixels), strategy=strategy, seed=5, show_environment=False)
                self.expect(session.render(samples=64), [rho * scattered for rho in ALBEDO], largest_error=1.5e-2)

    def test_background_alone(self):
        session = self.session(ls.Environment.constant((1.0, 2.0, 4.0)))
        session.transfer_function = homogeneous(EXTINCTION, (0.0, 0.0, 0.0))
        self.expect(session.render(samples=32), [self.through * light for light in (1.0, 2.0, 4.0)], largest_error=1e-2)

    def test_depth(self):
        """Mean distance of the first collision, given that there is one."""
        length = np.linalg.norm(self.end - self.start)
        image = self.session(ls.Environment.constant(), strategy="uniform").render(samples=64)
        outside = 3 * length
        inside = 1 / EXTINCTION - length * self.through / (1 - self.through)
        self.assertAlmostEqual(float(image.depth.mean()) / (outside + inside), 1.0, delta=2e-3)


if __name__ == "__main__":
    unittest.main()

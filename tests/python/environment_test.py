"""Environments: latitude-longitude and octahedral conventions, no light lost, the sky, refusals."""
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

import lumisweep as ls
from support import octahedral_uv, texel_indices

RNG = np.random.default_rng(3)


def latlong_directions(height, width):
    """Pixel centres by docs/scene.md: row 0 is +Z, u = 0.5 − φ / 2π."""
    polar = (np.arange(height) + 0.5)[:, None] * math.pi / height
    azimuth = (0.5 - (np.arange(width) + 0.5)[None, :] / width) * 2 * math.pi
    return np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)), axis=-1)


class LatLong(unittest.TestCase):
    def test_convention(self):
        pixels = RNG.random((8, 16, 3)).astype(np.float32)
        environment = ls.Environment.from_latlong(pixels)
        np.testing.assert_allclose(environment(latlong_directions(8, 16)), pixels, rtol=1e-5)
        # In words: right of the centre column is a little towards −Y of +X, the left quarter +Y.
        np.testing.assert_allclose(environment((1.0, -0.01, -0.1)), pixels[4, 8], rtol=1e-5)
        np.testing.assert_allclose(environment((0.1, 1.0, 0.1)), pixels[3, 4], rtol=1e-5)
        np.testing.assert_allclose(environment((0.02, 0.2, 1.0)), pixels[0, 4], rtol=1e-5)

    def test_rotation_and_scale(self):
        pixels = RNG.random((8, 16, 3))
        directions = latlong_directions(8, 16)
        cos, sin = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
        turned = directions @ np.array(((cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0)))
        environment = ls.Environment.from_latlong(pixels, scale=2.0, rotation_deg=30.0)
        np.testing.assert_allclose(environment(turned), 2.0 * pixels, rtol=1e-5)

    def test_no_light_is_lost(self):
        height, width = 12, 40
        pixels = RNG.random((height, width, 3))
        pixels[3, 17] = 10000.0  # a sun of one pixel
        edges = np.cos(np.arange(height + 1) * math.pi / height)
        solid_angle = (edges[:-1] - edges[1:])[:, None, None] * 2 * math.pi / width
        environment = ls.Environment.from_latlong(pixels)
        n = environment.resolution
        flux = environment.radiance.sum(axis=(0, 1), dtype=float) * 4 * math.pi / n ** 2
        np.testing.assert_allclose(flux, (pixels * solid_angle).sum(axis=(0, 1)), rtol=1e-6)
        mean = flux @ (0.2126, 0.7152, 0.0722) / (4 * math.pi)
        self.assertAlmostEqual(environment.mean_luminance / mean, 1.0, places=5)

    def test_what_no_light_can_be_becomes_dark(self):
        pixels = np.ones((8, 16, 3))
        pixels[2, 3], pixels[4, 5] = -1.0, np.nan
        environment = ls.Environment.from_latlong(pixels)
        self.assertTrue(environment.warnings)
        np.testing.assert_allclose(environment(latlong_directions(8, 16)[4, 5]), 0.0)


class Octahedral(unittest.TestCase):
    def test_directions_are_texel_centres(self):
        for n in (1, 2, 8, 32):
            directions = ls.octahedral_directions(n)
            self.assertEqual(directions.shape, (n, n, 3))
            np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0, atol=1e-12)
            u, v = octahedral_uv(directions)
            centres = (np.arange(n) + 0.5) / n
            if n > 1:  # the one texel's centre is +Z, whose azimuth is any
                np.testing.assert_allclose(u, np.broadcast_to(centres, (n, n)), atol=1e-9)
                np.testing.assert_allclose(v, np.broadcast_to(centres[:, None], (n, n)), atol=1e-9)

    def test_round_trip(self):
        texels = RNG.random((16, 16, 3)).astype(np.float32)
        environment = ls.Environment.from_octahedral(texels)
        self.assertEqual(environment.resolution, 16)
        np.testing.assert_array_equal(environment.radiance, texels)
        np.testing.assert_array_equal(environment(ls.octahedral_directions(16)).astype(np.float32), texels)

    def test_constant_over_a_texel(self):
        texels = RNG.random((8, 8, 3)).astype(np.float32)
        directions = RNG.normal(size=(2000, 3))
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        found = ls.Environment.from_octahedral(texels)(directions).astype(np.float32)
        wrong = np.any(found != texels[texel_indices(directions, 8)], axis=-1)
        self.assertLessEqual(wrong.sum(), 2)  # a direction on an edge may round to either side

    def test_radiance_is_a_copy(self):
        environment = ls.Environment.constant((1.0, 2.0, 3.0))
        environment.radiance[:] = 0.0
        np.testing.assert_allclose(environment((0.0, 0.0, 1.0)), (1.0, 2.0, 3.0))


class Others(unittest.TestCase):
    def test_sky(self):
        sky = ls.Environment.sky(sun_direction=(1.0, 0.0, 1.0), sun_irradiance=(5.0, 5.0, 5.0), sun_angular_diameter_deg=2.0)
        self.assertEqual(sky.resolution, 512)
        self.assertGreater(sky((0.7071, 0.0, 0.7071))[0], 100.0)
        np.testing.assert_allclose(sky((0.0, 0.1, -1.0)), (0.24, 0.21, 0.18), rtol=1e-5)
        black = dict.fromkeys(("zenith", "horizon", "ground"), (0.0, 0.0, 0.0))
        dark = ls.Environment.sky(**black, sun_irradiance=(5.0, 4.0, 3.0), resolution=128)
        np.testing.assert_allclose(dark.radiance.mean(axis=(0, 1), dtype=float) * 4 * math.pi, (5.0, 4.0, 3.0), rtol=1e-4)

    def test_file(self):
        with tempfile.TemporaryDirectory() as folder:
            pixels = RNG.random((8, 16, 3)).astype(np.float32)
            file = Path(folder) / "light.exr"
            ls.Image({"R": pixels[..., 0], "G": pixels[..., 1], "B": pixels[..., 2]}).write_exr(file)
            loaded = ls.Environment.load(file, scale=3.0, rotation_deg=70.0)
            converted = ls.Environment.from_latlong(pixels, scale=3.0, rotation_deg=70.0)
            np.testing.assert_array_equal(loaded.radiance, converted.radiance)
        with self.assertRaisesRegex(ls.Error, "light.exr"):
            ls.Environment.load(file)

    def test_refusals(self):
        for texels in (np.ones((6, 6, 3)), np.ones((8, 4, 3)), np.ones((8, 8)), -np.ones((8, 8, 3)), np.full((8, 8, 3), np.nan)):
            with self.assertRaises(ls.Error):
                ls.Environment.from_octahedral(texels)
        with self.assertRaises(ls.Error):
            ls.Environment.from_latlong(np.ones((8, 16)))
        with self.assertRaises(ls.Error):
            ls.Environment.constant((-1.0, 0.0, 0.0))
        with self.assertRaisesRegex(ls.Error, "sun_direction"):
            ls.Environment.sky(sun_direction=(0.0, 0.0, 0.0))
        with self.assertRaisesRegex(ls.Error, "scale"):
            ls.Environment.from_latlong(np.ones((8, 16, 3)), scale=-1.0)


if __name__ == "__main__":
    unittest.main()

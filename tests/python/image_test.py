"""Images: channels, EXR and PNG files, comparison, tone mapping."""
import importlib.util
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

import lumisweep as ls
from support import ball_session

RNG = np.random.default_rng(10)


def random_image(height=5, width=7):
    return ls.Image({name: RNG.random((height, width)).astype(np.float32) for name in "RGB"})


class Channels(unittest.TestCase):
    def test_by_name(self):
        red = RNG.random((3, 4))
        image = ls.Image({"R": red, "depth.Z": np.ones((3, 4))})
        self.assertEqual((image.width, image.height, sorted(image.channels)), (4, 3, ["R", "depth.Z"]))
        np.testing.assert_array_equal(image["R"], red.astype(np.float32))
        self.assertIn("depth.Z", image)
        self.assertNotIn("G", image)
        with self.assertRaises(KeyError):
            image["G"]

    def test_shapes_must_agree(self):
        for channels in ({"R": np.ones((3, 4)), "G": np.ones((4, 3))}, {"R": np.ones(3)}, {}):
            with self.assertRaises((ls.Error, ValueError, TypeError)):
                ls.Image(channels)

    def test_of_a_render(self):
        image = ball_session().render(samples=4)
        shape = (30, 40)
        for name, prefix, letters in (("radiance", "", "RGB"), ("variance", "Variance.", "RGB"), ("albedo", "albedo.", "RGB"),
                                      ("normal", "normal.", "XYZ")):
            values = getattr(image, name)
            self.assertEqual((values.shape, values.dtype), ((*shape, 3), np.dtype(np.float32)))
            for index, letter in enumerate(letters):
                np.testing.assert_array_equal(values[..., index], image[prefix + letter])
        np.testing.assert_array_equal(image.alpha, image["A"])
        np.testing.assert_array_equal(image.depth, image["depth.Z"])
        self.assertEqual(image.attributes["samplesPerPixel"], 4)
        self.assertEqual(image.attributes["strategy"], "auto")
        self.assertEqual(image.alpha[0].max(), 0.0)  # row 0 is above the ball
        self.assertGreater(image.alpha[15, 20], 0.5)


class Files(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def test_exr_round_trip(self):
        image = ball_session().render(samples=2)
        image.write_exr(self.folder / "a.exr")
        back = ls.read_exr(str(self.folder / "a.exr"))
        self.assertEqual(set(back.channels), set(image.channels))
        for channel in image.channels:
            np.testing.assert_array_equal(back[channel], image[channel])
        for name in ("strategy", "samplesPerPixel", "seed", "programVersion", "isa"):
            self.assertEqual(back.attributes[name], image.attributes[name])
        np.testing.assert_allclose(back.attributes["worldToCamera"], image.attributes["worldToCamera"], rtol=1e-6)

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "matplotlib is not installed")
    def test_png_holds_the_tone_mapped_pixels(self):
        from matplotlib.image import imread
        image = random_image()
        image.write_png(self.folder / "a.png", exposure=0.8)
        pixels = np.round(255 * imread(self.folder / "a.png")).astype(np.uint8)
        np.testing.assert_array_equal(pixels, image.tone_map(exposure=0.8))

    def test_errors(self):
        image = random_image()
        for attempt, name in ((ls.read_exr, "none.exr"), (image.write_exr, "none/a.exr"), (image.write_png, "none/a.png")):
            with self.assertRaisesRegex(ls.Error, "none"):
                attempt(self.folder / name)


class Comparison(unittest.TestCase):
    def test_against_numpy(self):
        a, b = random_image(), random_image()
        x, y = (image.radiance.astype(float) for image in (a, b))
        found = ls.compare(a, b)
        mse = ((x - y) ** 2).mean()
        expected = {"mse": mse, "rmse": math.sqrt(mse), "relmse": ((x - y) ** 2 / (y ** 2 + 0.01)).mean(),
                    "psnr": 10 * math.log10(y.max() ** 2 / mse), "mean_image": x.mean(), "mean_reference": y.mean()}
        self.assertEqual(set(found), set(expected))
        for name, value in expected.items():
            self.assertAlmostEqual(found[name] / value, 1.0, places=6, msg=name)
        self.assertEqual(ls.compare(a, a)["psnr"], math.inf)

    def test_errors(self):
        with self.assertRaises(ls.Error):
            ls.compare(random_image(5, 7), random_image(7, 5))
        with self.assertRaises(ls.Error):
            ls.compare(random_image(), ls.Image({name: np.full((5, 7), np.nan) for name in "RGB"}))


class ToneMap(unittest.TestCase):
    def test_grey(self):
        """Reinhard's curve with white at 1 leaves what is below it nearly linear: the sRGB curve of L (1 + L) / (1 + L) = L."""
        grey = np.linspace(0.0, 1.0, 64).reshape(8, 8)
        found = ls.Image({name: grey for name in "RGB"}).tone_map(exposure=1.0)
        self.assertEqual((found.shape, found.dtype), ((8, 8, 3), np.dtype(np.uint8)))
        srgb = np.where(grey <= 0.0031308, 12.92 * grey, 1.055 * grey ** (1 / 2.4) - 0.055)
        self.assertLessEqual(np.abs(found - 255 * srgb[..., None]).max(), 1.5)

    def test_exposure(self):
        image = random_image()
        self.assertGreater(image.tone_map(exposure=2.0).mean(), image.tone_map(exposure=0.5).mean())
        for exposure in (0.0, -1.0, math.nan):
            with self.assertRaises((ls.Error, ValueError)):
                image.tone_map(exposure=exposure)

    def test_without_the_environment_there_is_alpha(self):
        session = ball_session(image_settings=ls.ImageSettings(width=40, height=30, show_environment=False))
        image = session.render(samples=4)
        pixels = image.tone_map(show_environment=False)
        self.assertEqual(pixels.shape, (30, 40, 4))
        self.assertLessEqual(np.abs(pixels[..., 3] - 255 * np.clip(image.alpha, 0, 1)).max(), 1.0)
        np.testing.assert_array_equal(image.tone_map(), pixels)  # what the session hid stays hidden
        self.assertEqual(image.tone_map(show_environment=True).shape, (30, 40, 3))


if __name__ == "__main__":
    unittest.main()

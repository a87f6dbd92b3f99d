"""Who owns what: arrays that are not NumPy's, sweeps that outlive their array, grids that were set, limits of arguments."""
import gc
import unittest

import numpy as np

import lumisweep as ls
from support import ball, ball_session, ball_transfer_function, ball_volume, shareable, wide_sun


class Foreign:
    """Not an array, but it gives NumPy its own, as arrays of other packages do."""

    def __init__(self, array):
        self.array = array

    def __array__(self, dtype=None):
        return self.array


class Sources(unittest.TestCase):
    def test_buffers_and_foreign_arrays(self):
        for wrap in (memoryview, Foreign):
            with self.subTest(wrap.__name__):
                voxels = ball()
                source = wrap(voxels)
                shared, copied, insisted = ls.Volume(source), ls.Volume(source, copy=True), ls.Volume(source, copy=False)
                voxels[3, 4, 5] = 123
                self.assertTrue(shared.shared and insisted.shared)
                self.assertFalse(copied.shared)
                self.assertEqual((shared.voxels[3, 4, 5], insisted.voxels[3, 4, 5]), (123, 123))
                self.assertNotEqual(copied.voxels[3, 4, 5], 123)

    def test_lists_are_copies(self):
        volume = ls.Volume([[[1, 2], [3, 4]]])
        self.assertFalse(volume.shared)
        self.assertEqual(volume.dtype, np.uint8)
        with self.assertRaisesRegex(ls.Error, "copy"):
            ls.Volume([[[1, 2], [3, 4]]], copy=False)

    def test_masks_are_not_lost(self):
        with self.assertRaisesRegex(ls.Error, "masked"):
            ls.Volume(np.ma.masked_less(ball(), 0))

    def test_infinities_that_came_later(self):
        voxels = shareable(ball().astype(np.float32))
        volume = ls.Volume(voxels)
        session = ls.Session(volume, ball_transfer_function(), wide_sun())
        voxels[2, 2, 2] = np.inf
        with self.assertRaisesRegex(ls.Error, "infinite"):
            session.volume = volume
        with self.assertRaisesRegex(ls.Error, "infinite"):
            ls.Session(volume, ball_transfer_function(), wide_sun())


class Background(unittest.TestCase):
    def test_a_sweep_may_outlive_its_array(self):
        for _ in range(5):
            session = ball_session()
            session.sweep_in_background()
            session.render(samples=1)
            voxels = np.random.default_rng(2).integers(0, 500, (96, 96, 96)).astype(np.int16)
            session.volume = ls.Volume(voxels)
            session.render(samples=1)  # begins to sweep it
            session.volume = ball_volume()
            del voxels
            gc.collect()
            session.render(samples=2)
            session.prepare()
            self.assertFalse(session.sweeping)

    def test_thread_counts(self):
        session = ball_session()
        for threads in (-1, 100000, 2**31 - 1):
            with self.assertRaisesRegex(ls.Error, "threads"):
                session.sweep_in_background(threads)
        session.sweep_in_background(64)
        session.render(samples=1)


class Grids(unittest.TestCase):
    def test_what_was_set_is_there_whatever_the_strategy(self):
        for strategy in ("uniform", "two-step"):
            with self.subTest(strategy):
                session = ball_session(render_settings=ls.RenderSettings(strategy=strategy))
                values = np.zeros_like(session.visibility.values)
                values[2, 3] = 200
                session.visibility = ls.VisibilityGrid(values, session.volume, cell=4)
                np.testing.assert_array_equal(session.visibility.values, values)
                session.transfer_function = session.transfer_function  # swept anew
                self.assertGreater((session.visibility.values != values).mean(), 0.1)

    def test_epsilon_does_not_sweep(self):
        for strategy in ("uniform", "two-step"):
            with self.subTest(strategy):
                session = ball_session(render_settings=ls.RenderSettings(strategy=strategy))
                values = np.zeros_like(session.visibility.values)
                session.visibility = ls.VisibilityGrid(values, session.volume, cell=4)
                session.visibility_settings = session.visibility_settings.replace(epsilon=0.2)
                self.assertEqual(session.visibility.values.max(), 0)
                session.visibility_settings = session.visibility_settings.replace(filter="none")
                self.assertGreater(session.visibility.values.max(), 0)

    def test_seconds_stay_with_their_samples(self):
        session = ball_session()
        seconds = session.render(samples=400).attributes["renderSeconds"]
        session.visibility = session.visibility
        self.assertEqual(session.image().attributes["renderSeconds"], seconds)
        session.camera = session.camera
        self.assertLess(session.render(samples=1).attributes["renderSeconds"], seconds)


class Limits(unittest.TestCase):
    def test_steps(self):
        volume, function = ball_volume(), ball_transfer_function()
        for step in (0.0, -1.0, 1e-300, np.inf, np.nan):
            with self.assertRaisesRegex(ls.Error, "step"):
                ls.transmittance(volume, function, (0, 0, 0), (0, 0, 1), step_voxels=step)

    def test_names_are_strings(self):
        with self.assertRaises(TypeError):
            ls.Image({3: np.ones((2, 2))})
        with self.assertRaises(TypeError):
            ls.Session.load({"volume": {"file": "none.nrrd"}}, overrides={3: 4})


if __name__ == "__main__":
    unittest.main()

"""Sessions: the same image as the command line's, and what edits between passes do."""
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

import lumisweep as ls
from support import PLUME, ball, ball_session, ball_transfer_function, ball_volume, run_program, wide_sun

SCENE = {
    "version": 1,
    "volume": {"file": str(PLUME), "frame": 20},
    "transfer_function": {"points": [{"value": 5, "extinction": 0.0, "albedo": [0.9, 0.7, 0.6]},
                                     {"value": 255, "extinction": 30.0, "albedo": [0.95, 0.9, 0.85]}]},
    "image": {"width": 40, "height": 30},
    "render": {"samples": 6, "seed": 11},
    "visibility": {"cell": 2},
}


def same_pixels(a, b):
    return set(a.channels) == set(b.channels) and all(np.array_equal(a[name], b[name], equal_nan=True) for name in a.channels)


class CommandLine(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)
        self.scene = self.folder / "scene.json"
        self.scene.write_text(json.dumps(SCENE))

    def rendered(self, *arguments):
        run_program("render", self.scene, "-o", self.folder / "out.exr", *arguments)
        return ls.read_exr(self.folder / "out.exr")

    def test_scene_file_and_dictionary(self):
        expected = self.rendered()
        for scene in (self.scene, str(self.scene), SCENE):
            session = ls.Session.load(scene)
            image = session.render()
            self.assertEqual(session.samples, 6)
            self.assertTrue(same_pixels(image, expected))

    def test_overrides(self):
        self.assertTrue(same_pixels(ls.Session.load(SCENE, overrides={"render.seed": 3, "visibility.directions": 4}).render(),
                                    self.rendered("--seed", "3", "--set", "visibility.directions=4")))
        with self.assertRaisesRegex(ls.Error, "render.sed"):
            ls.Session.load(SCENE, overrides={"render.sed": 3})

    def test_built_from_objects(self):
        function = ls.TransferFunction(SCENE["transfer_function"]["points"])
        session = ls.Session(ls.Volume.load(PLUME, frame=20), function, image_settings=ls.ImageSettings(width=40, height=30),
                             render_settings=ls.RenderSettings(seed=11), visibility_settings=ls.VisibilitySettings(cell=2))
        self.assertTrue(same_pixels(session.render(samples=6), self.rendered()))

    def test_volume_alone(self):
        scene = {name: section for name, section in SCENE.items() if name != "transfer_function"}
        session = ls.Session.load(scene)
        self.scene.write_text(json.dumps(scene))
        self.assertTrue(any("smoke" in note for note in session.notes), session.notes)
        self.assertTrue(same_pixels(session.render(), self.rendered()))

    def test_paths_relative_to_a_base_directory(self):
        scene = {**SCENE, "volume": {"file": PLUME.name}}
        self.assertEqual(ls.Session.load(scene, base_directory=PLUME.parent).volume.shape, (96, 48, 48))
        with self.assertRaisesRegex(ls.Error, PLUME.name):
            ls.Session.load(scene, base_directory=self.folder)


class Repeatability(unittest.TestCase):
    def test_threads_do_not_change_a_bit(self):
        one = ball_session(threads=1).render(samples=3)
        self.assertTrue(same_pixels(ball_session(threads=3).render(samples=3), one))
        self.assertFalse(same_pixels(ball_session(render_settings=ls.RenderSettings(seed=1)).render(samples=3), one))

    def test_going_on_is_the_same_as_at_once(self):
        session = ball_session()
        early = session.render(samples=3)
        before = early.radiance.copy()
        self.assertTrue(same_pixels(session.render(samples=8), ball_session().render(samples=8)))
        np.testing.assert_array_equal(early.radiance, before)  # an image is no window on the film
        self.assertEqual(session.render(samples=8).attributes["samplesPerPixel"], 8)  # nothing left to do

    def test_stop_criteria(self):
        session = ball_session()
        session.render(noise=0.05)
        self.assertLessEqual(session.noise, 0.05)
        self.assertGreaterEqual(session.samples, 16)
        before = session.samples
        session.render(time=0.2)
        self.assertGreater(session.samples, before)
        for arguments in ({"samples": 4, "time": 1.0}, {"samples": 0}, {"time": -1.0}, {"noise": 0.0}):
            with self.subTest(**arguments), self.assertRaises((ls.Error, ValueError, TypeError)):
                session.render(**arguments)

    def test_instruction_sets(self):
        reference = ball_session(isa="baseline").render(samples=4).radiance
        for isa in ls.available_isas():
            session = ball_session(isa=isa)
            self.assertEqual(session.isa, isa)
            # The same random numbers, other rounding: paths part now and then, pictures hardly.
            self.assertLess(np.abs(session.render(samples=4).radiance - reference).mean(), 0.02 * reference.mean())


class Edits(unittest.TestCase):
    """Whatever is set between passes, the next image is a new session's to the bit."""

    EDITS = {
        "volume": lambda: ls.Volume(ball()[::-1].copy(), spacing=(2.0, 2.0, 2.5), origin=(-20.0, -25.0, -30.0)),
        "transfer_function": lambda: ls.TransferFunction([(50, 0.0, (0.2, 0.7, 0.6)), (300, 0.9, (0.95, 0.2, 0.85))]),
        "environment": lambda: ls.Environment.constant((1.0, 2.0, 3.0)),
        "camera": lambda: ls.Camera(position=(100.0, -50.0, 30.0), target=(0.0, 0.0, 0.0)),
        "image_settings": lambda: ls.ImageSettings(width=24, height=36, show_environment=False),
        "render_settings": lambda: ls.RenderSettings(strategy="combined", seed=7),
        "visibility_settings": lambda: ls.VisibilitySettings(directions=4, cell=3, filter="none", epsilon=0.5),
    }

    def start(self):
        return {"volume": ball_volume(), "transfer_function": ball_transfer_function(), "environment": wide_sun(),
                "camera": ls.Camera(position=(-60.0, -90.0, 20.0), target=(0.0, 0.0, 0.0)),
                "image_settings": ls.ImageSettings(width=30, height=20), "render_settings": ls.RenderSettings(),
                "visibility_settings": ls.VisibilitySettings()}

    def test_each(self):
        plain = ls.Session(**self.start()).render(samples=2)
        for name, edit in self.EDITS.items():
            with self.subTest(name):
                session = ls.Session(**self.start())
                session.render(samples=3)
                setattr(session, name, edit())
                self.assertEqual(session.samples, 0)
                image = session.render(samples=2)
                self.assertTrue(same_pixels(image, ls.Session(**{**self.start(), name: edit()}).render(samples=2)))
                self.assertFalse(same_pixels(image, plain))

    def test_all(self):
        session = ls.Session(**self.start())
        session.render(samples=3)
        for name, edit in self.EDITS.items():
            setattr(session, name, edit())
        self.assertTrue(same_pixels(session.render(samples=2),
                                    ls.Session(**{name: edit() for name, edit in self.EDITS.items()}).render(samples=2)))

    def test_a_shared_array_changed_in_place(self):
        voxels = ball()
        session = ls.Session(**{**self.start(), "volume": ls.Volume(voxels)})
        session.render(samples=2)
        voxels[:, :, :12] = -200
        session.volume = session.volume
        self.assertTrue(same_pixels(session.render(samples=2),
                                    ls.Session(**{**self.start(), "volume": ls.Volume(voxels, copy=True)}).render(samples=2)))

    def test_refused_edits_leave_the_session_as_it_was(self):
        session = ls.Session(**self.start())
        before = session.render(samples=2)
        for name, value in (("volume", ball()), ("camera", "front"), ("render_settings", ls.ImageSettings()),
                            *((name, None) for name in self.EDITS)):
            with self.subTest(name), self.assertRaises((TypeError, ls.Error)):
                setattr(session, name, value)
        with self.assertRaises((TypeError, ls.Error)):
            ls.Session(None)
        self.assertTrue(same_pixels(session.image(), before))

    def test_in_the_background(self):
        session = ls.Session(**self.start())
        session.sweep_in_background()
        session.render(samples=2)
        session.volume = self.EDITS["volume"]()
        session.render(samples=1)
        session.prepare()
        self.assertFalse(session.sweeping)
        expected = ls.Session(**{**self.start(), "volume": self.EDITS["volume"]()})
        expected.prepare()
        np.testing.assert_array_equal(session.visibility.values, expected.visibility.values)
        session.sweep_before_pass()
        session.camera = session.camera.replace(vertical_fov_deg=30.0)
        expected.camera = session.camera
        self.assertTrue(same_pixels(session.render(samples=2), expected.render(samples=2)))

    def test_stats(self):
        session = ls.Session(**self.start())
        session.render(samples=2)
        stats = session.stats
        self.assertEqual(stats["paths"], 2 * 30 * 20)
        for stage in ("classify", "majorants", "sweep", "joint", "render"):
            self.assertGreater(stats["seconds"][stage], 0.0)
            self.assertLess(stats["seconds"][stage], 60.0)
        sweep = stats["seconds"]["sweep"]
        session.environment = ls.Environment.constant()
        session.render(samples=2)
        self.assertEqual(session.stats["seconds"]["sweep"], sweep)  # a new light does not sweep again


if __name__ == "__main__":
    unittest.main()

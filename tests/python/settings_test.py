"""Settings: the scene file's names and defaults, keyword-only, replaced by copies, refused by name."""
import copy
import pickle
import unittest

import numpy as np

import lumisweep as ls
from support import STRATEGIES

DEFAULTS = {
    ls.Camera: {"up": (0.0, 0.0, 1.0), "vertical_fov_deg": 35.0, "lens_radius": 0.0, "focus_distance": None},
    ls.ImageSettings: {"width": 512, "height": 512, "show_environment": True},
    ls.RenderSettings: {"strategy": "auto", "random_numbers": "auto", "shadow_rays": "auto", "seed": 0},
    ls.VisibilitySettings: {"directions": 8, "cell": 4, "rays": "auto", "filter": "half-angle", "oversampling": 1,
                            "epsilon": 0.1},
}
OTHERS = {
    ls.Camera: {"position": (1.0, 2.0, 3.0), "target": (4.0, 5.0, 7.0), "up": (1.0, 0.0, 0.0), "vertical_fov_deg": 20.0,
                "lens_radius": 0.5, "focus_distance": 3.0},
    ls.ImageSettings: {"width": 7, "height": 9, "show_environment": False},
    ls.RenderSettings: {"strategy": "two-step", "random_numbers": "stratified", "shadow_rays": 5, "seed": 2**64 - 1},
    ls.VisibilitySettings: {"directions": 16, "cell": 2, "rays": 64, "filter": "none", "oversampling": 4, "epsilon": 0.01},
}


class Settings(unittest.TestCase):
    def test_defaults(self):
        for kind, entries in DEFAULTS.items():
            settings = kind()
            for name, value in entries.items():
                with self.subTest(kind=kind.__name__, name=name):
                    self.assertEqual(getattr(settings, name), value)

    def test_entries_are_kept(self):
        for kind, entries in OTHERS.items():
            settings = kind(**entries)
            for name, value in entries.items():
                with self.subTest(kind=kind.__name__, name=name):
                    self.assertEqual(getattr(settings, name), value)

    def test_every_choice(self):
        for name, kind, choices in (("strategy", ls.RenderSettings, STRATEGIES),
                                    ("random_numbers", ls.RenderSettings, ("auto", "independent", "stratified")),
                                    ("filter", ls.VisibilitySettings, ("none", "half-angle", "full-angle"))):
            for choice in choices:
                self.assertEqual(getattr(kind(**{name: choice}), name), choice)

    def test_keyword_only(self):
        for make in (lambda: ls.Camera((0, 0, 1)), lambda: ls.ImageSettings(512), lambda: ls.RenderSettings("auto"),
                     lambda: ls.VisibilitySettings(8)):
            with self.assertRaises(TypeError):
                make()

    def test_replace_leaves_the_original(self):
        for kind, entries in OTHERS.items():
            for name, value in entries.items():
                with self.subTest(kind=kind.__name__, name=name):
                    original = kind()
                    before = {entry: getattr(original, entry) for entry in entries}
                    changed = original.replace(**{name: value})
                    self.assertIs(type(changed), kind)
                    self.assertEqual({entry: getattr(original, entry) for entry in entries}, before)
                    self.assertEqual({entry: getattr(changed, entry) for entry in entries}, {**before, name: value})

    def test_they_do_not_change(self):
        """A session takes settings whole: a change of what it gave would go nowhere, silently."""
        for kind, entries in OTHERS.items():
            for name, value in entries.items():
                with self.subTest(kind=kind.__name__, name=name), self.assertRaises(AttributeError):
                    setattr(kind(), name, value)

    def test_copies_and_pickles(self):
        for kind, entries in OTHERS.items():
            settings = kind(**entries)
            for made in (copy.copy(settings), copy.deepcopy(settings), pickle.loads(pickle.dumps(settings))):
                self.assertEqual(made, settings)
            self.assertNotEqual(settings, kind())

    def test_unknown_entries(self):
        for kind in OTHERS:
            for make in (kind, kind().replace):
                with self.subTest(kind=kind.__name__), self.assertRaisesRegex((TypeError, ls.Error), "widht"):
                    make(widht=3)

    def test_refusals_name_the_entry(self):
        for kind, name, value in ((ls.ImageSettings, "width", 0), (ls.ImageSettings, "height", 16385),
                                  (ls.RenderSettings, "shadow_rays", 65), (ls.RenderSettings, "shadow_rays", 0),
                                  (ls.RenderSettings, "strategy", "best"), (ls.RenderSettings, "seed", -1),
                                  (ls.RenderSettings, "random_numbers", "none"),
                                  (ls.VisibilitySettings, "directions", 12), (ls.VisibilitySettings, "cell", 0),
                                  (ls.VisibilitySettings, "epsilon", 0.0), (ls.VisibilitySettings, "oversampling", 2),
                                  (ls.VisibilitySettings, "filter", "half"), (ls.VisibilitySettings, "rays", 0),
                                  (ls.Camera, "vertical_fov_deg", 180.0), (ls.Camera, "lens_radius", -1.0),
                                  (ls.Camera, "focus_distance", -2.0), (ls.Camera, "up", (0.0, 0.0, 0.0))):
            with self.subTest(kind=kind.__name__, name=name, value=value):
                with self.assertRaisesRegex((ls.Error, ValueError, TypeError), name):
                    kind(**{name: value})
                with self.assertRaisesRegex((ls.Error, ValueError, TypeError), name):
                    kind().replace(**{name: value})


class Camera(unittest.TestCase):
    def test_camera_from_world(self):
        camera = ls.Camera(position=(10.0, 20.0, 30.0), target=(10.0, 50.0, 30.0))  # along +Y
        matrix = camera.camera_from_world()
        np.testing.assert_allclose(matrix @ (10, 20, 30, 1), (0, 0, 0, 1), atol=1e-12)
        np.testing.assert_allclose(matrix @ (10, 50, 30, 1), (0, 0, 30, 1), atol=1e-12)  # z along the view
        np.testing.assert_allclose(matrix @ (11, 20, 30, 1), (1, 0, 0, 1), atol=1e-12)   # x to the right
        np.testing.assert_allclose(matrix @ (10, 20, 31, 1), (0, 1, 0, 1), atol=1e-12)   # y up

    def test_framed(self):
        voxels = np.zeros((20, 30, 40), np.uint8)
        voxels[5:9, 10:14, 20:24] = 200
        volume = ls.Volume(voxels, origin=(100.0, 0.0, 0.0))
        shown = ls.TransferFunction([(0, 0.0, (1, 1, 1)), (200, 1.0, (1, 1, 1))])
        camera = ls.Camera.framed(volume, shown, vertical_fov_deg=20.0)
        self.assertEqual(camera.vertical_fov_deg, 20.0)
        np.testing.assert_allclose(camera.target, (121.5, 11.5, 6.5), atol=1.1)
        near = ls.Camera.framed(volume, shown)
        self.assertLess(np.linalg.norm(np.subtract(near.position, near.target)),
                        np.linalg.norm(np.subtract(camera.position, camera.target)))


if __name__ == "__main__":
    unittest.main()

"""Transfer functions: values to extinction and albedo, presets, refusals."""
import unittest

import numpy as np

import lumisweep as ls
from support import PLUME, ball_volume

POINTS = [(-100.0, 0.0, (0.9, 0.7, 0.6)), (50.0, 2.0, (0.5, 0.6, 0.7)), (300.0, 5.0, (1.0, 0.0, 0.25))]


class Evaluation(unittest.TestCase):
    def test_piecewise_linear_and_clamped(self):
        function = ls.TransferFunction(POINTS)
        values = np.linspace(-400.0, 600.0, 2001).reshape(3, -1)
        extinction, albedo = function(values)
        self.assertEqual((extinction.shape, albedo.shape), (values.shape, (*values.shape, 3)))
        knots = [value for value, _, _ in POINTS]
        np.testing.assert_allclose(extinction, np.interp(values, knots, [e for _, e, _ in POINTS]), atol=1e-12)
        for channel in range(3):
            expected = np.interp(values, knots, [colour[channel] for _, _, colour in POINTS])
            np.testing.assert_allclose(albedo[..., channel], expected, atol=1e-12)

    def test_scale(self):
        extinction, albedo = ls.TransferFunction(POINTS, extinction_scale=3.0)(50.0)
        self.assertAlmostEqual(float(extinction), 6.0)
        np.testing.assert_allclose(albedo, POINTS[1][2])

    def test_nan_is_empty(self):
        self.assertEqual(ls.TransferFunction([(0.0, 7.0, (1, 1, 1))])([np.nan, 0.0])[0].tolist(), [0.0, 7.0])

    def test_a_step_holds_from_its_value_on(self):
        step = ls.TransferFunction([(10.0, 0.0, (1, 1, 1)), (10.0, 4.0, (1, 1, 1))])
        self.assertEqual(step([9.999, 10.0, 10.001])[0].tolist(), [0.0, 4.0, 4.0])


class Points(unittest.TestCase):
    def test_tuples_and_mappings_are_the_same(self):
        mappings = [{"value": value, "extinction": extinction, "albedo": albedo} for value, extinction, albedo in POINTS]
        self.assertEqual(ls.TransferFunction(mappings).points, ls.TransferFunction(POINTS).points)
        self.assertEqual(ls.TransferFunction(mappings).points, POINTS)
        self.assertEqual(ls.TransferFunction(iter(POINTS)).points, POINTS)

    def test_albedo_is_white_when_absent(self):
        self.assertEqual(ls.TransferFunction([{"value": 1, "extinction": 2}]).points, [(1.0, 2.0, (1.0, 1.0, 1.0))])

    def test_scale_is_kept_apart(self):
        function = ls.TransferFunction(POINTS, extinction_scale=3.0)
        self.assertEqual(function.points, POINTS)
        self.assertEqual(function.extinction_scale, 3.0)

    def test_refusals_name_the_entry(self):
        white = (1, 1, 1)
        for points, name in (([], "points"), ([(5, 1, white), (4, 1, white)], "value"), ([(0, -1, white)], "extinction"),
                             ([(0, 1, (1, 1, 1.5))], "albedo"), ([(np.nan, 1, white)], "value"),
                             ([{"value": 1, "extinktion": 2}], "extinktion"), ([{"value": 1}], "extinction")):
            with self.subTest(points=points), self.assertRaisesRegex(ls.Error, name):
                ls.TransferFunction(points)
        with self.assertRaisesRegex(ls.Error, "extinction_scale"):
            ls.TransferFunction(POINTS, extinction_scale=-1.0)
        with self.assertRaises((ls.Error, TypeError, ValueError)):
            ls.TransferFunction([(1.0, 2.0)])


class Presets(unittest.TestCase):
    def test_every_name(self):
        volume = ball_volume()
        self.assertIn("ct-bone", ls.preset_names())
        for name in ls.preset_names():
            with self.subTest(name):
                function = ls.TransferFunction.preset(name, volume)
                self.assertGreater(function(1000.0)[0], 0.0)
        with self.assertRaisesRegex(ls.Error, "ct-bones"):
            ls.TransferFunction.preset("ct-bones", volume)

    def test_automatic(self):
        plume = ls.Volume.load(PLUME, frame=20)
        chosen = ls.TransferFunction.preset("auto", plume, extinction_scale=2.0)
        self.assertEqual(chosen.extinction_scale, 2.0)
        self.assertIn(chosen.points, [ls.TransferFunction.preset(name, plume).points for name in ls.preset_names()])
        self.assertEqual(ls.Session(plume).transfer_function.points, chosen.points)


if __name__ == "__main__":
    unittest.main()

"""Where voxels lie in the world: spacing, origin and affine, and what interpolation finds there."""
import unittest

import numpy as np

import lumisweep as ls
from support import PLUME

VOXELS = np.random.default_rng(2).integers(-500, 500, (3, 4, 5)).astype(np.int16)


class Placement(unittest.TestCase):
    def expect_voxels_at(self, volume, positions):
        """`positions` [z, y, x, 3] are the centres of VOXELS."""
        np.testing.assert_allclose(volume.interpolate(positions), VOXELS, atol=1e-9)

    def test_without_any(self):
        volume = ls.Volume(VOXELS)
        np.testing.assert_array_equal(volume.affine, np.eye(4))
        self.assertEqual(volume.spacing, (1.0, 1.0, 1.0))
        k, j, i = np.indices(VOXELS.shape)
        self.expect_voxels_at(volume, np.stack([i, j, k], axis=-1))

    def test_spacing_and_origin(self):
        volume = ls.Volume(VOXELS, spacing=(0.5, 2.0, 3.0), origin=(-7.0, 11.0, 100.0))
        self.assertEqual(volume.spacing, (0.5, 2.0, 3.0))
        np.testing.assert_allclose(volume.affine, [[0.5, 0, 0, -7], [0, 2, 0, 11], [0, 0, 3, 100], [0, 0, 0, 1]])
        k, j, i = np.indices(VOXELS.shape)
        self.expect_voxels_at(volume, np.stack([0.5 * i - 7, 2.0 * j + 11, 3.0 * k + 100], axis=-1))

    def test_affine(self):
        affine = np.array([[0.0, -2.0, 0.3, 10.0], [1.0, 0.0, 0.0, -5.0], [0.1, 0.0, 3.0, 2.0], [0.0, 0.0, 0.0, 1.0]])
        volume = ls.Volume(VOXELS, affine=affine)
        np.testing.assert_allclose(volume.affine, affine, atol=1e-12)
        np.testing.assert_allclose(volume.spacing, np.linalg.norm(affine[:3, :3], axis=0))
        k, j, i = np.indices(VOXELS.shape)
        self.expect_voxels_at(volume, (np.stack([i, j, k, np.ones_like(i)], axis=-1) @ affine.T)[..., :3])

    def test_trilinear_between_and_clamped_outside(self):
        volume = ls.Volume(VOXELS)
        self.assertAlmostEqual(float(volume.interpolate((1.5, 2.0, 1.0))), VOXELS[1, 2, 1:3].mean())
        self.assertAlmostEqual(float(volume.interpolate((1.5, 2.5, 0.5))), VOXELS[0:2, 2:4, 1:3].mean())
        self.assertEqual(volume.interpolate((-50.0, 1.0, 2.0)), VOXELS[2, 1, 0])
        self.assertEqual(volume.interpolate((4.4, 3.4, 2.4)), VOXELS[2, 3, 4])

    def test_slope_and_intercept(self):
        volume = ls.Volume(VOXELS, slope=0.5, intercept=-1000.0)
        self.assertEqual((volume.slope, volume.intercept), (0.5, -1000.0))
        np.testing.assert_array_equal(volume.voxels, VOXELS)
        self.assertAlmostEqual(float(volume.interpolate((2.0, 1.0, 0.0))), 0.5 * VOXELS[0, 1, 2] - 1000.0)

    def test_shapes_of_positions(self):
        volume = ls.Volume(VOXELS)
        self.assertEqual(volume.interpolate((0.0, 0.0, 0.0)).shape, ())
        self.assertEqual(volume.interpolate(np.zeros((7, 3))).shape, (7,))
        self.assertEqual(volume.interpolate(np.zeros((2, 0, 3))).shape, (2, 0))
        for wrong in (np.zeros((7, 2)), 1.0, np.zeros((3, 7))):
            with self.assertRaises((ls.Error, TypeError, ValueError)):
                volume.interpolate(wrong)

    def test_impossible_placements(self):
        singular = np.diag([1.0, 1.0, 0.0, 1.0])
        for arguments in ({"affine": singular}, {"affine": np.full((4, 4), np.nan)}, {"affine": np.eye(3)},
                          {"affine": np.eye(4), "spacing": (2.0, 2.0, 2.0)}, {"spacing": (1.0, 0.0, 1.0)},
                          {"origin": (np.inf, 0.0, 0.0)}):
            with self.subTest(**arguments), self.assertRaises((ls.Error, TypeError, ValueError)):
                ls.Volume(VOXELS, **arguments)


class Files(unittest.TestCase):
    def test_header_and_frames(self):
        header = ls.inspect_volume(PLUME)
        self.assertEqual(header["frames"], 40)
        first, later = ls.Volume.load(PLUME), ls.Volume.load(PLUME, frame=20)
        self.assertEqual(first.shape, (96, 48, 48))
        self.assertEqual(first.dtype, np.dtype(np.uint8))
        self.assertFalse(first.shared)
        np.testing.assert_allclose(first.spacing, [1 / 24] * 3, rtol=1e-6)
        self.assertFalse(np.array_equal(first.voxels, later.voxels))
        with self.assertRaisesRegex(ls.Error, "40"):
            ls.Volume.load(PLUME, frame=40)

    def test_missing_file(self):
        with self.assertRaisesRegex(ls.Error, "nowhere.nrrd"):
            ls.Volume.load("nowhere.nrrd")


if __name__ == "__main__":
    unittest.main()

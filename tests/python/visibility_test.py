"""Visibility: transmittance in closed form, brute force against it, sweeps against brute force, and which way indices run."""
import unittest

import numpy as np

import lumisweep as ls
from support import ball_transfer_function, ball_volume, box_volume, distance_to_box, homogeneous

RNG = np.random.default_rng(5)
OPAQUE = ls.TransferFunction([(0.4, 0.0, (1, 1, 1)), (0.6, 50.0, (1, 1, 1))])


def random_directions(count):
    directions = RNG.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


class Transmittance(unittest.TestCase):
    def test_homogeneous_box(self):
        volume, half = box_volume()
        positions = RNG.uniform(-1, 1, (400, 3)) * half
        directions = random_directions(400)
        expected = np.exp(-0.8 * distance_to_box(half, positions, directions))
        for reference in ("exact", "classified"):
            with self.subTest(reference):
                found = ls.transmittance(volume, homogeneous(0.8), positions, directions, reference=reference)
                np.testing.assert_allclose(found, expected, atol=1e-6)

    def test_interpolated_before_or_after_classifying(self):
        """Between 0 and 1 a hat of the transfer function at 1/2: the voxels' own values do not show it."""
        voxels = np.zeros((8, 8, 8), np.float32)
        voxels[:, :, 4:] = 1.0
        volume = ls.Volume(voxels)
        hat = ls.TransferFunction([(0.25, 0.0, (1, 1, 1)), (0.5, 4.0, (1, 1, 1)), (0.75, 0.0, (1, 1, 1))])
        along = {"positions": (-0.4, 3.5, 3.5), "directions": (1.0, 0.0, 0.0)}
        # The value rises from 0 to 1 over one voxel: ∫ σ = half of the hat's width times its height.
        self.assertAlmostEqual(float(ls.transmittance(volume, hat, **along, step_voxels=0.001)), float(np.exp(-1.0)), places=4)
        self.assertEqual(ls.transmittance(volume, hat, **along, reference="classified"), 1.0)

    def test_broadcasting(self):
        volume, _ = box_volume()
        thin, directions = homogeneous(0.1), ls.octahedral_directions(4)
        found = ls.transmittance(volume, thin, (0.1, 0.0, 0.0), directions)
        self.assertEqual(found.shape, (4, 4))
        positions = np.zeros((5, 1, 1, 3)) + np.arange(5)[:, None, None, None] * 0.05
        self.assertEqual(ls.transmittance(volume, thin, positions, directions).shape, (5, 4, 4))
        self.assertEqual(ls.transmittance(volume, thin, (0, 0, 0), (0, 0, 1)).shape, ())
        np.testing.assert_array_equal(ls.transmittance(volume, thin, positions, directions, threads=1)[2],
                                      ls.transmittance(volume, thin, (0.1, 0.1, 0.1), directions))


class Orientation(unittest.TestCase):
    def test_shape(self):
        volume = ls.Volume(np.zeros((12, 20, 27), np.uint8))
        grid = ls.sweep_visibility(volume, OPAQUE, ls.VisibilitySettings(directions=2))
        self.assertEqual(grid.values.shape, (2, 2, 3, 5, 7))
        self.assertEqual((grid.cells, grid.directions), ((7, 5, 3), 2))
        self.assertTrue((grid.values == 255).all())

    def test_slabs(self):
        """Opaque at one end of an axis: dark towards it, bright away from it, from everywhere before it."""
        directions = ls.octahedral_directions(8)
        for axis in range(3):  # x, y, z
            for end in (0, -1):
                voxels = np.zeros((24, 20, 16), np.uint8)
                np.moveaxis(voxels, 2 - axis, 0)[:4] = 1
                voxels = np.flip(voxels, 2 - axis).copy() if end else voxels
                outwards = 1 if end else -1
                grid = ls.sweep_visibility(ls.Volume(voxels), OPAQUE, ls.VisibilitySettings(filter="none"))
                # Cells from the second after the slab's, as the first may see a part of it.
                free = np.flip(grid.values, 4 - axis) if end else grid.values
                free = np.moveaxis(free, 4 - axis, 2)[:, :, 2:]
                towards, away = directions[..., axis] * outwards > 0.9, directions[..., axis] * outwards < -0.9
                with self.subTest(axis="xyz"[axis], end=end):
                    self.assertGreater(towards.sum(), 1)
                    middle = tuple(slice(side // 2 - 1, side // 2 + 1) for side in free.shape[3:])
                    self.assertLess(free[towards][:, :2, middle[0], middle[1]].max(), 25)
                    self.assertGreater(free[away].min(), 250)

    def test_cell_centres(self):
        affine = np.array([[0.0, -2.0, 0.3, 10.0], [1.0, 0.0, 0.0, -5.0], [0.1, 0.0, 3.0, 2.0], [0.0, 0.0, 0.0, 1.0]])
        shape = (5, 9, 14)
        centres = ls.cell_centres(ls.Volume(np.zeros(shape, np.uint8), affine=affine), cell=4)
        self.assertEqual(centres.shape, (2, 3, 4, 3))
        k, j, i = np.indices((2, 3, 4)) + 0.5
        index = np.stack([i * 14 / 4 - 0.5, j * 9 / 3 - 0.5, k * 5 / 2 - 0.5, np.ones_like(i)], axis=-1)
        np.testing.assert_allclose(centres, (index @ affine.T)[..., :3], atol=1e-9)


class Grids(unittest.TestCase):
    def setUp(self):
        self.volume, self.function = ball_volume(), ball_transfer_function()

    def test_brute_force_is_transmittance_at_cells(self):
        settings = ls.VisibilitySettings(directions=4)
        centres, directions = ls.cell_centres(self.volume), ls.octahedral_directions(4)[:, :, None, None, None, :]
        for reference in ("classified", "exact"):
            with self.subTest(reference):
                grid = ls.brute_force_visibility(self.volume, self.function, settings, reference=reference)
                expected = ls.transmittance(self.volume, self.function, centres, directions, reference=reference)
                self.assertLessEqual(np.abs(grid.values / 255 - expected).max(), 0.5 / 255 + 1e-9)
                self.assertLess(grid.values.min(), 100)

    def test_sweeps_agree_with_brute_force(self):
        """Closest without the filter, which averages over a cone: of a ball that is opaque within a few voxels, on purpose."""
        reference = ls.brute_force_visibility(self.volume, self.function).values / 255
        rms = {}
        for name in ("none", "half-angle", "full-angle"):
            swept = ls.sweep_visibility(self.volume, self.function, ls.VisibilitySettings(filter=name)).values / 255
            rms[name] = np.sqrt(((swept - reference) ** 2).mean())
        self.assertLess(rms["none"], 0.02)
        self.assertLess(rms["half-angle"], 0.12)
        self.assertLess(rms["half-angle"], rms["full-angle"])
        # An axis swapped or a direction turned round is far more than that.
        wrong = ls.sweep_visibility(self.volume, self.function).values[::-1] / 255
        self.assertGreater(np.sqrt(((wrong - reference) ** 2).mean()), 2 * rms["full-angle"])

    def test_threads_do_not_change_a_bit(self):
        one = ls.sweep_visibility(self.volume, self.function, threads=1)
        self.assertGreater(one.stats["voxel_steps"], 0)
        np.testing.assert_array_equal(ls.sweep_visibility(self.volume, self.function, threads=3).values, one.values)

    def test_from_values(self):
        shape = ls.sweep_visibility(self.volume, self.function, ls.VisibilitySettings(directions=4)).values.shape
        bytes_ = RNG.integers(0, 256, shape, np.uint8)
        np.testing.assert_array_equal(ls.VisibilityGrid(bytes_, self.volume, cell=4).values, bytes_)
        np.testing.assert_array_equal(ls.VisibilityGrid(bytes_ / 255, self.volume, cell=4).values, bytes_)
        self.assertEqual(ls.VisibilityGrid(bytes_, self.volume, cell=4).stats, {})
        for values, cell in ((bytes_, 3), (bytes_[:3], 4), (bytes_[:, :, 1:], 4), (np.full(shape, 1.5), 4),
                             (np.full(shape, -0.1), 4), (np.full(shape, np.nan), 4), (bytes_.astype(np.int32), 4)):
            with self.assertRaises((ls.Error, TypeError, ValueError)):
                ls.VisibilityGrid(values, self.volume, cell=cell)

    def test_a_session_takes_only_its_own_shape(self):
        session = ls.Session(self.volume, self.function, image_settings=ls.ImageSettings(width=8, height=8))
        session.prepare()
        np.testing.assert_array_equal(session.visibility.values, ls.sweep_visibility(self.volume, self.function).values)
        with self.assertRaises(ls.Error):
            session.visibility = ls.sweep_visibility(self.volume, self.function, ls.VisibilitySettings(directions=4))


if __name__ == "__main__":
    unittest.main()

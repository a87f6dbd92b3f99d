"""Volumes from arrays: types, sharing and lifetime."""
import gc
import mmap
import tempfile
import unittest
import weakref

import numpy as np

import lumisweep as ls
from support import ball, shareable

KEPT = (np.uint8, np.uint16, np.int16, np.float32)


class Types(unittest.TestCase):
    def expect_type(self, voxels, dtype):
        volume = ls.Volume(voxels)
        self.assertEqual(volume.dtype, np.dtype(dtype))
        self.assertEqual(volume.voxels.dtype, np.dtype(dtype))
        self.assertFalse(volume.shared)
        np.testing.assert_array_equal(volume.voxels, voxels)

    def test_kept_types(self):
        for dtype in KEPT:
            with self.subTest(dtype=dtype.__name__):
                voxels = np.arange(60, dtype=dtype).reshape(3, 4, 5)
                volume = ls.Volume(voxels)
                self.assertEqual((volume.shape, volume.dtype), ((3, 4, 5), np.dtype(dtype)))
                np.testing.assert_array_equal(volume.voxels, voxels)

    def test_smallest_type_that_holds_every_value(self):
        for values, dtype in (((0, 255), np.uint8), ((0, 256), np.uint16), ((-1, 255), np.int16), ((0, 65535), np.uint16),
                              ((-32768, 32767), np.int16), ((-1, 40000), np.float32), ((0, 65536), np.float32)):
            for wide in (np.int64, np.int32, np.float64):
                with self.subTest(values=values, wide=wide.__name__):
                    self.expect_type(np.array(values, wide).reshape(1, 1, 2), dtype)
        self.expect_type(np.array([0.5, 1.0]).reshape(1, 1, 2), np.float32)
        self.expect_type(np.array([-3, 7], np.int8).reshape(1, 1, 2), np.int16)
        self.expect_type(np.array([0.25, 2.0], np.float16).reshape(1, 1, 2), np.float32)

    def test_truth_values(self):
        volume = ls.Volume(ball() > 0)
        self.assertEqual(volume.dtype, np.dtype(np.uint8))
        np.testing.assert_array_equal(volume.voxels, ball() > 0)

    def test_what_float32_cannot_hold_is_rounded(self):
        volume = ls.Volume(np.array([1 / 3, 2**24 + 1]).reshape(1, 1, 2))
        np.testing.assert_array_equal(volume.voxels[0, 0], np.array([1 / 3, 2**24 + 1], np.float32))

    def test_big_endian(self):
        voxels = np.arange(24, dtype=">i2").reshape(2, 3, 4) - 7
        self.expect_type(voxels.astype(">i2"), np.int16)
        with self.assertRaises(ls.Error):
            ls.Volume(voxels.astype(">i2"), copy=False)

    def test_nan_is_empty_and_infinities_become_nan(self):
        voxels = shareable(np.ones((4, 4, 4), np.float32))
        voxels[1, 1, 1] = np.nan
        shared = ls.Volume(voxels)
        self.assertTrue(shared.shared)
        voxels[2, 2, 2] = -np.inf
        copied = ls.Volume(voxels)
        self.assertFalse(copied.shared)
        self.assertTrue(np.isneginf(voxels[2, 2, 2]))  # the caller's array is left alone
        self.assertEqual(np.isnan(copied.voxels).sum(), 2)
        self.assertTrue(any("not finite" in warning or "infinit" in warning for warning in copied.warnings), copied.warnings)
        with self.assertRaises(ls.Error):
            ls.Volume(voxels, copy=False)
        self.assertTrue(np.isnan(copied.interpolate((2.0, 2.0, 2.0))))
        self.assertEqual(copied.interpolate((0.0, 3.0, 3.0)), 1.0)

    def test_impossible_arrays(self):
        for voxels in (np.ones((4, 4)), np.ones((2, 3, 4, 5)), np.ones((0, 4, 4)), np.ones((2, 2, 2), complex),
                       np.full((2, 2, 2), "a"), np.full((2, 2, 2), None)):
            with self.subTest(shape=voxels.shape, dtype=str(voxels.dtype)), self.assertRaises((ls.Error, TypeError)):
                ls.Volume(voxels)


class Sharing(unittest.TestCase):
    def test_shared_memory(self):
        for dtype in KEPT:
            with self.subTest(dtype=dtype.__name__):
                voxels = shareable(ball().astype(dtype))
                volume = ls.Volume(voxels)
                self.assertTrue(volume.shared)
                self.assertTrue(np.shares_memory(volume.voxels, voxels))
                voxels[3, 4, 5] = 77
                self.assertEqual(volume.voxels[3, 4, 5], 77)
                self.assertEqual(volume.interpolate((5.0, 4.0, 3.0)), 77.0)

    def test_voxels_are_read_only(self):
        voxels = ball()
        for volume in (ls.Volume(voxels), ls.Volume(voxels, copy=True)):
            with self.assertRaises(ValueError):
                volume.voxels[0, 0, 0] = 1

    def test_copy(self):
        voxels = ball()
        volume = ls.Volume(voxels, copy=True)
        self.assertFalse(volume.shared)
        self.assertFalse(np.shares_memory(volume.voxels, voxels))
        self.assertTrue(ls.Volume(voxels, copy=False).shared)

    def test_fortran_order_transposed(self):
        array = ball().transpose()  # [x, y, z] in Fortran order, as nibabel has it
        volume = ls.Volume(array.T, copy=False)
        self.assertTrue(volume.shared)
        self.assertTrue(np.shares_memory(volume.voxels, array))
        self.assertEqual(volume.shape, array.shape[::-1])

    def test_what_is_not_contiguous_is_copied(self):
        voxels = ball()
        for name, view in (("strided", voxels[::2]), ("cut", voxels[:, 1:-1]), ("reversed", voxels[::-1]),
                           ("Fortran order", np.asfortranarray(voxels)), ("transposed", voxels.transpose(2, 1, 0)),
                           ("broadcast", np.broadcast_to(np.int16(3), (4, 5, 6)))):
            with self.subTest(name):
                volume = ls.Volume(view)
                self.assertFalse(volume.shared)
                np.testing.assert_array_equal(volume.voxels, view)
                with self.assertRaisesRegex(ls.Error, "copy"):
                    ls.Volume(view, copy=False)

    def test_slices_along_z_are_shared(self):
        voxels = ball()
        volume = ls.Volume(voxels[4:])
        self.assertTrue(volume.shared)
        np.testing.assert_array_equal(volume.voxels, voxels[4:])

    def test_mapped_files(self):
        """Shared unless the voxels end where a page does: kernels read a little beyond them, and that page may not be there."""
        for columns, shared in ((mmap.PAGESIZE // 64, False), (mmap.PAGESIZE // 64 - 1, True)):
            with self.subTest(shared=shared), tempfile.NamedTemporaryFile() as file:
                sides = (16, 16, columns)
                expected = np.random.default_rng(1).integers(0, 255, sides, np.uint8)
                file.write(expected.tobytes())
                file.flush()
                voxels = np.memmap(file.name, np.uint8, "r", shape=sides)
                volume = ls.Volume(voxels)
                self.assertEqual(volume.shared, shared)
                self.assertEqual(np.shares_memory(volume.voxels, voxels), shared)
                self.assertFalse(np.shares_memory(ls.Volume(voxels, copy=True).voxels, voxels))
                np.testing.assert_array_equal(volume.voxels, expected)
                if not shared:
                    with self.assertRaisesRegex(ls.Error, "page"):
                        ls.Volume(voxels, copy=False)

    def test_read_only_arrays_are_shared(self):
        voxels = ball()
        voxels.flags.writeable = False
        self.assertTrue(ls.Volume(voxels).shared)

    def test_lists_are_taken(self):
        np.testing.assert_array_equal(ls.Volume([[[1, 2], [3, 4]]]).voxels, [[[1, 2], [3, 4]]])


class Lifetime(unittest.TestCase):
    def test_the_volume_keeps_its_array(self):
        voxels = shareable(np.random.default_rng(1).integers(0, 255, (64, 64, 64), np.uint8))
        expected, watch = voxels.copy(), weakref.ref(voxels)
        volume = ls.Volume(voxels)
        self.assertTrue(volume.shared)
        del voxels
        gc.collect()
        rubbish = [np.full((64, 64, 64), 255, np.uint8) for _ in range(8)]  # would take the memory if it were free
        np.testing.assert_array_equal(volume.voxels, expected)
        self.assertIsNotNone(watch())
        del volume, rubbish
        gc.collect()
        self.assertIsNone(watch(), "the array is never let go")

    def test_a_view_keeps_the_volume(self):
        view = ls.Volume(ball(), copy=True).voxels
        gc.collect()
        np.testing.assert_array_equal(view, ball())

    def test_a_session_keeps_volume_and_array(self):
        def session():
            return ls.Session(ls.Volume(ball()), ls.TransferFunction([(100, 0.0, (1, 1, 1)), (400, 0.4, (1, 1, 1))]),
                              image_settings=ls.ImageSettings(width=16, height=16))

        kept = session()
        gc.collect()
        rubbish = [np.full_like(ball(), 30000) for _ in range(8)]
        np.testing.assert_array_equal(kept.volume.voxels, ball())
        kept.render(samples=2)
        self.assertEqual(len(rubbish), 8)


if __name__ == "__main__":
    unittest.main()

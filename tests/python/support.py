"""What the module's tests share: small volumes and sessions, octahedral coordinates, corrected statistics.

Standard library and NumPy only; the module comes from PYTHONPATH, the program's path is the first argument where a test runs it.
"""
import math
import mmap
import os
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np

import lumisweep as ls

ROOT = Path(__file__).resolve().parent.parent.parent
PLUME = ROOT / "tests" / "data" / "plume_4d_density.nrrd"
PROGRAM = str(Path(sys.argv.pop(1)).resolve()) if len(sys.argv) > 1 and Path(sys.argv[1]).is_file() else None
STRATEGIES = ("uniform", "environment", "visibility", "combined", "two-step", "auto")


def run_program(*arguments):
    """Runs the command-line program; a test that needs it skips without."""
    if PROGRAM is None:
        raise unittest.SkipTest("the program's path is not given")
    # A sanitizer that was put into this interpreter for the module's sake is not the program's own.
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, timeout=120, env=environment)


def run_python(*arguments, **options):
    return subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, timeout=300, **options)


# --- volumes --------------------------------------------------------------------------------------------------------------

def shareable(array):
    """The same voxels where a volume can share them for certain: with the end in the middle of a page."""
    page, size = mmap.PAGESIZE, array.nbytes
    memory = np.empty(size + 2 * page, np.uint8)
    start = (page // 2 - memory.ctypes.data - size) % page
    voxels = memory[start:start + size].view(array.dtype).reshape(array.shape)
    voxels[...] = array
    return voxels


def ball(size=24):
    """A soft ball with a hollow, beside the middle, int16 [z, y, x]: nothing about it is symmetric."""
    z, y, x = np.indices((size, size + 4, size - 2)) / size - 0.5
    r = np.sqrt((x + 0.02) ** 2 + (y - 0.1) ** 2 + z ** 2) * 2
    return shareable(np.where(r > 0.3, 1000 * np.maximum(0.0, 1.0 - r), -200).astype(np.int16))


def ball_volume(**arguments):
    return ls.Volume(ball(), **{"spacing": (2.0, 2.0, 2.5), "origin": (-20.0, -25.0, -30.0), **arguments})


def ball_transfer_function():
    return ls.TransferFunction([(100, 0.0, (0.9, 0.7, 0.6)), (400, 0.4, (0.95, 0.9, 0.85))])


def wide_sun():
    """A sun so wide that uniform directions find it, too."""
    return ls.Environment.sky(sun_angular_diameter_deg=90.0, resolution=64)


def ball_session(width=40, height=30, **arguments):
    settings = {"image_settings": ls.ImageSettings(width=width, height=height), **arguments}
    return ls.Session(ball_volume(), ball_transfer_function(), wide_sun(), **settings)


def box_volume(shape=(6, 4, 5), spacing=(0.5, 0.6, 0.4)):
    """One value everywhere, the middle of the box at the origin; and the box's half sides (x, y, z)."""
    size, spacing = np.array(shape[::-1]), np.array(spacing)
    return ls.Volume(np.ones(shape, np.uint8), spacing=spacing, origin=tuple((0.5 - size / 2) * spacing)), size * spacing / 2


def homogeneous(extinction, albedo=(1.0, 1.0, 1.0)):
    return ls.TransferFunction([(0.0, extinction, albedo)])


def distance_to_box(half, positions, directions):
    """From positions inside of the box [-half, half] along unit directions to its surface."""
    with np.errstate(divide="ignore"):
        return np.min((half - np.sign(directions) * positions) / np.abs(directions), axis=-1)


def sphere_directions(n):
    """n × 2n unit directions, each standing for the same solid angle, by z and azimuth: not the module's own map."""
    z = (np.arange(n) + 0.5)[:, None] * 2 / n - 1
    azimuth = (np.arange(2 * n) + 0.5)[None, :] * math.pi / n
    rho = np.sqrt(1 - z ** 2)
    return np.stack(np.broadcast_arrays(rho * np.cos(azimuth), rho * np.sin(azimuth), z), axis=-1)


def octahedral_uv(directions):
    """(u, v) in [0, 1] of directions: Clarberg's equal-area map, straight from the paper."""
    x, y, z = np.moveaxis(np.asarray(directions, float), -1, 0)
    r = np.sqrt(1 - np.abs(z))
    v = r * np.arctan2(np.abs(y), np.abs(x)) * 2 / math.pi
    u = r - v
    u, v = np.where(z < 0, 1 - v, u), np.where(z < 0, 1 - u, v)
    return (np.copysign(u, x) + 1) / 2, (np.copysign(v, y) + 1) / 2


def texel_indices(directions, n):
    """(row v, column u) of the texels of the n × n map that directions lie in."""
    u, v = octahedral_uv(directions)
    return tuple(np.minimum((coordinate * n).astype(int), n - 1) for coordinate in (v, u))


# --- statistics -----------------------------------------------------------------------------------------------------------

def sidak(alpha, tests):
    """The level of each of several tests at which all of them together raise a false alarm with probability alpha."""
    return 1 - (1 - alpha) ** (1 / tests)


def normal_p(z):
    """Two-sided."""
    return math.erfc(abs(z) / math.sqrt(2))


def chi_square_p(statistic, degrees):
    """The chance of a larger statistic, by Wilson and Hilferty's cube root: good to a few per cent of it above ten degrees."""
    spread = 2 / (9 * degrees)
    return 0.5 * math.erfc(((statistic / degrees) ** (1 / 3) - (1 - spread)) / math.sqrt(2 * spread))


def image_mean(image):
    """Mean radiance of all pixels per channel, and its standard error."""
    pixels = image.width * image.height
    return image.radiance.mean(axis=(0, 1), dtype=float), np.sqrt(image.variance.sum(axis=(0, 1), dtype=float)) / pixels

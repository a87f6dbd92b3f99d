"""Lumisweep: unbiased volume rendering under natural light.

    session = lumisweep.Session(lumisweep.Volume(array, spacing=(1, 1, 2)))
    session.render(samples=64).write_png("first.png")

Arrays of voxels and cells are [z, y, x]; positions, spacings and directions are (x, y, z). See docs/python.md.
"""
from lumisweep._core import *  # noqa: F403
from lumisweep._core import __version__ as __version__

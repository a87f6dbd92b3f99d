#!/usr/bin/python3
"""A time series in one session: frames of a smoke plume, side by side.

Sweeps run in the background: a new frame's first pass goes ahead with the visibility that is there, and takes up what has been
swept meanwhile. The grid only says where to look for light, so the picture's mean is right from the first sample.

    examples/smoke.py [--output FILE.png] [--width N] [--samples N]     --width is that of one frame
"""
import time

import matplotlib.image
import numpy as np

import lumisweep as ls
from gallery import ROOT, arguments

options = arguments(__file__, __doc__, width=160, samples=64)

series = ROOT / "tests" / "data" / "plume_4d_density.nrrd"
count = ls.inspect_volume(series)["frames"]
frames = [ls.Volume.load(series, frame=frame) for frame in range(3, count, 6)]

white = (0.96, 0.96, 0.97)
smoke = ls.TransferFunction([(5, 0.0, white), (255, 30.0, white)])
evening = ls.Environment.sky(zenith=(0.16, 0.25, 0.50), horizon=(0.9, 0.6, 0.4), ground=(0.10, 0.08, 0.07),
                             sun_direction=(-1.0, -0.2, 0.5), sun_irradiance=(8.0, 5.6, 3.8))
session = ls.Session(frames[0], smoke, evening,
                     camera=ls.Camera(position=(1, -9, 1.2), target=(1, 1, 2), vertical_fov_deg=26),
                     image_settings=ls.ImageSettings(width=options.width, height=options.width * 2),
                     visibility_settings=ls.VisibilitySettings(cell=2))
session.sweep_in_background()

pictures = []
for frame in frames:
    start = time.perf_counter()
    session.volume = frame
    session.render(samples=1)
    first = time.perf_counter() - start
    pictures.append(session.render(samples=options.samples).tone_map(exposure=1.0))
    print(f"first sample after {first * 1000:.0f} ms, {session.samples} after {time.perf_counter() - start:.2f} s")

matplotlib.image.imsave(options.output, np.hstack(pictures))
print(options.output)

#!/usr/bin/python3
"""A file, a transfer function, a photographed light: a CT of a head, its bone, under a morning sun.

The PNG is for looking at; the EXR beside it holds linear radiance, variance, albedo, normal and depth.
Data: scripts/fetch_data ct_head sunrise

    examples/ct_head.py [--output FILE.png] [--width N] [--samples N]
"""
import lumisweep as ls
from gallery import arguments, data

options = arguments(__file__, __doc__, width=640, samples=64)

head = ls.Volume.load(data("ct_head.nrrd"))
print(f"{head.shape} voxels (z, y, x) of {head.dtype}, {head.spacing} mm apart")

# Hounsfield units to extinction per millimetre and albedo. The head rest reaches 565 HU: bone starts above it.
bone = ls.TransferFunction([(565, 0.0, (0.88, 0.75, 0.60)),
                            (800, 3.0, (0.95, 0.88, 0.78)),
                            (2000, 6.0, (0.99, 0.98, 0.96))])
morning = ls.Environment.load(data("environments/sunrise.exr"), rotation_deg=30)

session = ls.Session(head, bone, morning,
                     camera=ls.Camera(position=(-150, -470, 50), target=(0, 0, -8), vertical_fov_deg=23, lens_radius=1.5,
                                      focus_distance=400),
                     image_settings=ls.ImageSettings(width=options.width, height=options.width))
picture = session.render(samples=options.samples,
                         progress=lambda samples, seconds: print(f"\r{samples} samples, {seconds:.1f} s", end="", flush=True))
print(f"\nrelative error {session.noise:.2%}, swept for {session.stats['seconds']['sweep']:.2f} s")

picture.write_png(options.output)
picture.write_exr(options.output.with_suffix(".exr"))
print(f"{options.output} and {options.output.with_suffix('.exr').name}")

#!/usr/bin/python3
"""A NumPy array, and edits between passes: an aorta with a stent under two lights, and cut open.

One session renders all three. A new light leaves the visibility sweeps as they are, changed voxels redo them.
Data: scripts/fetch_data stent sunrise interior

    examples/stent.py [--output FILE.png] [--width N] [--samples N]
"""
import matplotlib.image
import numpy as np

import lumisweep as ls
from gallery import arguments, data

options = arguments(__file__, __doc__, width=360, samples=64)

# Any source of a [z, y, x] array will do; here it is the scan's own, copied to be changed below.
voxels = ls.Volume.load(data("stent.nrrd")).voxels.copy()
size = np.array(voxels.shape[::-1])
scan = ls.Volume(voxels, spacing=(1.0, 1.0, 1.0), origin=tuple(0.5 - size / 2))  # 1 mm, its middle at the origin
print(f"the session reads the array itself: {np.shares_memory(voxels, scan.voxels)}")

vessels_and_metal = ls.TransferFunction([(190, 0.0, (0.72, 0.20, 0.14)),
                                         (300, 0.8, (0.80, 0.28, 0.20)),
                                         (430, 1.5, (0.90, 0.70, 0.55)),
                                         (560, 2.5, (0.95, 0.92, 0.86)),
                                         (1000, 6.0, (0.93, 0.95, 0.98))])
sunrise = ls.Environment.load(data("environments/sunrise.exr"), rotation_deg=270)
interior = ls.Environment.load(data("environments/interior.exr"), scale=2.0)

session = ls.Session(scan, vessels_and_metal, sunrise,
                     camera=ls.Camera(position=(120, -500, 30), target=(0, 0, 0), vertical_fov_deg=29),
                     image_settings=ls.ImageSettings(width=options.width, height=options.width * 3 // 2))


def picture(what):
    before = session.stats["seconds"]
    image = session.render(samples=options.samples)
    seconds = {stage: after - before[stage] for stage, after in session.stats["seconds"].items()}
    print(f"{what}: swept for {seconds['sweep']:.2f} s, rendered for {seconds['render']:.1f} s")
    return image.tone_map()


pictures = [picture("at sunrise")]
session.environment = interior
pictures.append(picture("indoors"))
voxels[:, : voxels.shape[1] // 2, :] = 0  # everything in front of the middle
session.volume = scan                     # says that the array has changed
session.environment = sunrise
pictures.append(picture("cut open"))

matplotlib.image.imsave(options.output, np.hstack(pictures))
print(options.output)

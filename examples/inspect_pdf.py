#!/usr/bin/python3
"""A microscope for directions: at one point of a surface, where light comes from and where each strategy looks for it.

Maps are octahedral: +Z is the middle, −Z the corners, +X to the right, +Y up; every texel covers the same solid angle. Above
each density p stand mean and relative variance of the estimate L V / p over directions drawn from it, with L the light's
luminance and V the exact transmittance to the outside. The means agree; the variances are why one density is better than another.
Data: scripts/fetch_data ct_head courtyard

    examples/inspect_pdf.py [--output FILE.png] [--width N] [--samples N]     texels along a map, directions a strategy
"""
import matplotlib
import numpy as np
from matplotlib import colors

import lumisweep as ls
from gallery import arguments, data

matplotlib.use("Agg")  # no screen needed
from matplotlib import pyplot

options = arguments(__file__, __doc__, width=128, samples=4096, small=(32, 256))

volume = ls.Volume.load(data("ct_head.nrrd"))
bone = ls.TransferFunction([(565, 0.0, (0.88, 0.75, 0.60)), (800, 3.0, (0.95, 0.88, 0.78))])
environment = ls.Environment.load(data("environments/courtyard.exr"))
visibility = ls.sweep_visibility(volume, bone)

# The point: on the cheekbone, where a tenth of the light along a ray from the camera has been lost.
camera, cheek = np.array([-150.0, -470.0, 50.0]), np.array([-50.0, -60.0, -30.0])
view = (cheek - camera) / np.linalg.norm(cheek - camera)
along = camera + np.arange(300.0, 600.0, 0.25)[:, None] * view
point = along[np.argmax(ls.transmittance(volume, bone, along, -view) < 0.9)]


def luminance(radiance):
    return radiance @ (0.2126, 0.7152, 0.0722)


def shrunk(texels):
    """Means over squares of texels: a map of at most the width asked for."""
    n = 2 ** (min(options.width, len(texels)).bit_length() - 1)
    return texels.reshape(n, len(texels) // n, n, len(texels) // n).mean(axis=(1, 3))


light = shrunk(luminance(environment.radiance))
exact = ls.transmittance(volume, bone, point, ls.octahedral_directions(len(light)))
k, j, i = np.unravel_index(np.argmin(np.linalg.norm(ls.cell_centres(volume) - point, axis=-1)), visibility.cells[::-1])
maps = {"light": light, "exact visibility": exact, "swept visibility of the cell": visibility.values[:, :, k, j, i] / 255,
        "light × exact visibility": light * exact}

numbers = np.random.default_rng(0).random((options.samples, 3))
for strategy in ("uniform", "environment", "visibility", "combined", "two-step"):
    sampler = ls.DirectionSampler(strategy, volume, environment, visibility)
    directions, pdf = sampler.sample(point, numbers)
    estimates = luminance(environment(directions)) * ls.transmittance(volume, bone, point, directions) / pdf
    mean, error = estimates.mean(), estimates.std() / np.sqrt(options.samples)
    estimate = f"{mean:.3f} ± {error:.3f}, variance {estimates.var() / mean**2:.2f}"
    print(f"{strategy}: {estimate}")
    maps[f"{strategy}\n{estimate}"] = shrunk(sampler.pdf_map(point))

figure, axes = pyplot.subplots(3, 3, figsize=(10, 11), layout="constrained")
for (title, texels), axis in zip(maps.items(), axes.flat):
    shares = title.endswith(("visibility", "of the cell")) and "×" not in title
    norm = colors.Normalize(0, 1) if shares else colors.LogNorm(texels.mean() / 30, texels.mean() * 30, clip=True)
    axis.imshow(texels, origin="lower", norm=norm, extent=(-1, 1, -1, 1))
    axis.set(title=title, xticks=[], yticks=[])
figure.savefig(options.output, dpi=100)
print(options.output)

#!/usr/bin/python3
"""NIfTI without a copy: a brain, translucent, from an [x, y, z] array and its affine as nibabel gives them.

Data: scripts/fetch_data ch2better studio

    examples/mr.py [--output FILE.png] [--width N] [--samples N]
"""
import gzip

import numpy as np

import lumisweep as ls
from gallery import arguments, data

options = arguments(__file__, __doc__, width=640, samples=64)


def read_nifti(path):
    """8-bit voxels [x, y, z] in Fortran order and the affine to RAS millimetres.

    With nibabel: image = nibabel.load(path), then np.asarray(image.dataobj) and image.affine.
    """
    file = gzip.decompress(path.read_bytes())
    size = np.frombuffer(file, "<i2", count=3, offset=42)
    first_voxel = int(np.frombuffer(file, "<f4", count=1, offset=108)[0])
    affine = np.vstack([np.frombuffer(file, "<f4", count=12, offset=280).reshape(3, 4), [0, 0, 0, 1]])
    return np.frombuffer(file, np.uint8, count=size.prod(), offset=first_voxel).reshape(size, order="F"), affine


path = data("ch2better.nii.gz")
voxels, affine = read_nifti(path)
lps_from_ras = np.diag([-1.0, -1.0, 1.0, 1.0])
brain = ls.Volume(voxels.T, affine=lps_from_ras @ affine)  # the transpose is [z, y, x] in C order: no copy
print(f"{brain.shape} voxels (z, y, x), shared with NumPy: {brain.shared}")

from_file = ls.Volume.load(path)
assert np.array_equal(from_file.voxels, brain.voxels) and np.allclose(from_file.affine, brain.affine)

# Light goes a centimetre or two deep into the grey matter, over denser white matter: the folds stay soft.
pink, cream = (0.92, 0.62, 0.52), (0.97, 0.88, 0.80)
tissue = ls.TransferFunction([(50, 0.0, pink), (75, 0.04, pink), (95, 0.06, cream), (118, 0.4, cream)])
session = ls.Session(brain, tissue, ls.Environment.load(data("environments/studio.exr")),
                     camera=ls.Camera(position=(-270, -330, 120), target=(0, 18, 10), vertical_fov_deg=25),
                     image_settings=ls.ImageSettings(width=options.width, height=options.width))
session.render(samples=options.samples).write_png(options.output)
print(f"relative error {session.noise:.2%}: {options.output}")

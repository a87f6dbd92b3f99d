"""Timings that the papers print, for tables beside ours."""

# Journal paper, Table 1: seconds on a GeForce GTX 760, Manix 512 × 512 × 460, by rays and voxels per cell.
PAPER_CELLS = (2, 4, 8, 16)
PAPER_SWEEPS = {16: (3.76, 1.93, 0.76, 0.53), 32: (3.89, 1.97, 0.79, 0.54), 64: (4.05, 2.03, 0.79, 0.55),
                128: (4.31, 2.40, 1.04, 0.59), 256: (6.36, 3.23, 1.63, 1.41)}
PAPER_BRUTE_FORCE = (97.35, 15.17, 2.79, 0.57)
PAPER_MEGABYTES = (964.7, 120.6, 15.0, 1.8)
# Table 2: seconds without the filter on a GTX Titan and the filter's overhead factor, by rays; cells of 8³ voxels.
PAPER_VOLUMES = {"Engine": (256, 256, 128), "Fluid": (256, 256, 256), "Smoke": (384, 384, 512),
                 "Backpack": (512, 512, 373), "Statue": (535, 342, 690), "Manix": (512, 512, 460)}
PAPER_FILTER = {"Engine": ((0.63, 2.05), (0.98, 1.28), (2.33, 0.55)),
                "Fluid": ((0.60, 2.36), (1.03, 1.42), (2.72, 0.52)),
                "Smoke": ((1.05, 2.26), (1.75, 1.40), (4.56, 0.57)),
                "Backpack": ((1.09, 3.08), (1.81, 1.88), (4.96, 0.81)),
                "Statue": ((1.29, 3.24), (2.05, 2.17), (5.47, 0.85)),
                "Manix": ((1.46, 2.42), (2.21, 1.66), (5.33, 0.81))}


def slices_of_cells(name, cell):
    """That all 64 directions of a sweep go through; as many of them run along each axis."""
    return 64 / 3 * sum(-(-side // cell) for side in PAPER_VOLUMES[name])

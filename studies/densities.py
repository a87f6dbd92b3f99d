"""Two-step's density from any grid of visibilities, and the variance that it leaves at single points, by summation.

What a render cannot have, visibility in floating point or classified otherwise, can be compared here: a point's estimator V L /
p has the second moment ∫ (V L)² / p dω, and with V on a fine octahedral map and the light as it is that is a sum. V is exact in
it; what shadow rays add by estimating V is left out.
"""
import numpy as np

import plots
import scenes
from common import StudyError, markdown_rows, with_error
from measure import LUMINANCE
from scenes import lumisweep


def octahedral_means(values, n):
    """The means of a map [m, m, ...] over the n × n texels of a coarser one."""
    m = values.shape[0]
    return values.reshape(n, m // n, n, m // n, *values.shape[2:]).mean(axis=(1, 3))


# --- points ---------------------------------------------------------------------------------------------------------------

class Points:
    """First collisions of camera rays, drawn from a render of one sample.

    The render's jitter within a pixel is not known, so that a point is off its collision by part of a pixel; points that fall
    into empty space by that are left out.
    """

    def __init__(self, session, count, rng, pixels=1024):
        volume, camera = session.volume, session.camera
        session.image_settings = lumisweep.ImageSettings(width=pixels, height=pixels, show_environment=False)
        session.render_settings = lumisweep.RenderSettings(strategy="uniform")
        image = session.render(samples=1)
        row, column = np.nonzero((image.alpha > 0) & (image.depth > 0))
        chosen = rng.permutation(len(row))[:2 * count]
        half = np.tan(np.radians(camera.vertical_fov_deg) / 2)
        x, y = (2 * (column[chosen] + 0.5) / pixels - 1) * half, (1 - 2 * (row[chosen] + 0.5) / pixels) * half
        directions = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.asarray(camera.camera_from_world())[:3, :3]
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        positions = np.asarray(camera.position) + image.depth[row[chosen], column[chosen], None] * directions
        extinction, albedo = session.transfer_function(volume.interpolate(positions))
        solid = np.flatnonzero(extinction > 0)[:count]
        self.positions, self.albedo = positions[solid], albedo[solid]


class Corners:
    """The eight cells around every point: their indices [points, 8, (z, y, x)] and trilinear weights [points, 8]."""

    def __init__(self, volume, positions, cell):
        size = np.array(volume.shape[::-1])
        self.cells = -(-size // cell)
        index = (np.linalg.inv(volume.affine) @ np.append(positions, np.ones((len(positions), 1)), axis=1).T).T[:, :3]
        # V is meant at cells' centres; beyond the outer ones it is constant.
        at = np.clip((index + 0.5) * self.cells / size - 0.5, 0, self.cells - 1)
        base = np.minimum(at.astype(int), np.maximum(self.cells - 2, 0))
        step = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)])
        fraction = (at - base)[:, None]
        self.weights = np.where(step, fraction, 1 - fraction).prod(axis=-1)
        self.indices = np.minimum(base[:, None] + step, self.cells - 1)[..., ::-1]

    def of_grid(self, values):
        """[points, 8, n, n] of a visibility grid's values."""
        return values[:, :, self.indices[..., 0], self.indices[..., 1], self.indices[..., 2]].transpose(2, 3, 0, 1) / 255.0

    def at_cells(self, volume, cell, evaluate):
        """[points, 8, …] of what evaluate(centres [cells, 3]) gives for cells, each once: neighbours share them."""
        flat = np.ravel_multi_index(tuple(np.moveaxis(self.indices, -1, 0)), tuple(self.cells[::-1]))
        distinct, inverse = np.unique(flat, return_inverse=True)
        return evaluate(lumisweep.cell_centres(volume, cell=cell).reshape(-1, 3)[distinct])[inverse.reshape(flat.shape)]


def to_8_bits(values):
    return np.round(values * 255) / 255


# --- light ----------------------------------------------------------------------------------------------------------------

class Light:
    """What the sums need of an environment, over the texels of a fine map and of the leaves."""

    def __init__(self, environment, fine, leaves):
        radiance = environment.radiance.astype(np.float64)
        luminance = radiance @ LUMINANCE
        self.leaf = octahedral_means(luminance, leaves)
        self.radiance = octahedral_means(radiance, fine)
        # Within a leaf two-step's density follows the luminance, so that L² / p has this over the leaf's value.
        self.squared = octahedral_means(np.divide(radiance ** 2, luminance[..., None], out=np.zeros_like(radiance),
                                                  where=luminance[..., None] > 0), fine)
        self.of_leaf = luminance / np.repeat(np.repeat(self.leaf, len(luminance) // leaves, 0), len(luminance) // leaves, 1)


def leaf_density(corners, visibility, light, epsilon):
    """[points, n, n]: density of the leaves, per unit of the octahedral square."""
    product = (visibility + epsilon) * light.leaf
    value = np.einsum("pc,pcvu->pvu", corners.weights, product)
    return value / value.mean(axis=(1, 2), keepdims=True)


def variance(exact, light, density, albedo):
    """[points]: of one sample of a point's radiance, mean over R, G, B. exact: V [points, fine, fine]."""
    points, n, fine = len(exact), density.shape[1], exact.shape[1]
    each = fine // n
    # Per unit of the square, of which 4π are steradians and the phase function is 1 / 4π.
    ratio = np.divide(light.leaf, density, out=np.zeros_like(density), where=density > 0)
    second = np.einsum("pvu,pvaub,vaubc->pc", ratio, exact.reshape(points, n, each, n, each) ** 2,
                       light.squared.reshape(n, each, n, each, 3), optimize=True) / fine ** 2
    mean = np.einsum("pvu,vuc->pc", exact, light.radiance) / fine ** 2
    return ((second - mean ** 2) * albedo ** 2).mean(axis=-1)


def check_density(volume, environment, grid, corners, positions, light, epsilon, count=4):
    """The largest relative difference of this density from the sampler's own, over whole maps at a few points."""
    sampler = lumisweep.DirectionSampler("two-step", volume, environment, grid, epsilon=epsilon)
    ours = leaf_density(corners, corners.of_grid(grid.values), light, epsilon)[:count]
    times = environment.resolution // ours.shape[1]
    worst = 0.0
    for position, of_point in zip(positions, ours):
        expected = np.repeat(np.repeat(of_point, times, 0), times, 1) * light.of_leaf / (4 * np.pi)
        found = sampler.pdf_map(position)
        worst = max(worst, float(np.abs(found - expected).max() / expected.max()),
                    float(np.max(np.abs(found - expected)[expected > 0] / expected[expected > 0])))
    return worst


# --- the experiment -------------------------------------------------------------------------------------------------------

EPSILONS = [0.01, 0.1]
LEAVES, CELL = 8, 4
RAYS_TO_AVERAGE = 16
FLOAT, ROUNDED = "centres", "centres, 8 bits"
EXACT, EXACT_ROUNDED = "centres, interpolated first", "centres, interpolated first, 8 bits"
AVERAGED, OWN = "mean over cell and texel", "the point's own mean over a texel"
SWEPT = {kind: f"swept, {kind}" for kind in ("none", "half-angle", "full-angle")}
ENVIRONMENT = "environment sampling"
# What is divided by what.
RATIOS = [("8 bits / float", ROUNDED, FLOAT), ("8 bits / float, interpolated first", EXACT_ROUNDED, EXACT),
          ("classified first / interpolated first", FLOAT, EXACT),
          ("swept without a filter / centres", SWEPT["none"], ROUNDED),
          ("swept, half angle / centres", SWEPT["half-angle"], ROUNDED),
          ("swept, full angle / centres", SWEPT["full-angle"], ROUNDED), ("mean over cell and texel / centres", AVERAGED, FLOAT),
          ("the point's own mean over a texel / centres", OWN, FLOAT), ("environment sampling / centres", ENVIRONMENT, FLOAT)]


def random_rays(volume, transfer_function, centres, cells, n, rng):
    """[centres, n, n]: V from a random place in each cell in a random direction of each texel.

    `cells` (x, y, z) is how many the volume is divided into.
    """
    within = 16
    fine = lumisweep.octahedral_directions(n * within)
    sides = np.asarray(volume.affine)[:3, :3] * (np.array(volume.shape[::-1]) / cells)
    places = centres[:, None, None] + rng.uniform(-0.5, 0.5, (len(centres), n, n, 3)) @ sides.T
    texel = np.arange(n) * within
    row, column = (first + rng.integers(0, within, (len(centres), n, n)) for first in (texel[:, None], texel))
    return lumisweep.transmittance(volume, transfer_function, places, fine[row, column], reference="classified")


def visibilities(volume, transfer_function, points, corners, exact, rng):
    """{variant: [points, 8, n, n]} and the default's grid."""
    grids = {kind: lumisweep.sweep_visibility(volume, transfer_function, lumisweep.VisibilitySettings(filter=kind))
             for kind in SWEPT}
    directions = lumisweep.octahedral_directions(LEAVES)
    centres = {reference: corners.at_cells(volume, CELL, lambda at, r=reference: lumisweep.transmittance(
        volume, transfer_function, at[:, None, None], directions, reference=r)) for reference in ("classified", "exact")}
    own = octahedral_means(np.moveaxis(exact, 0, -1), LEAVES)

    def averages(at):
        rays = (random_rays(volume, transfer_function, at, corners.cells, LEAVES, rng) for _ in range(RAYS_TO_AVERAGE))
        return sum(rays) / RAYS_TO_AVERAGE

    found = {FLOAT: centres["classified"], ROUNDED: to_8_bits(centres["classified"]), EXACT: centres["exact"],
             EXACT_ROUNDED: to_8_bits(centres["exact"]), AVERAGED: corners.at_cells(volume, CELL, averages),
             OWN: np.broadcast_to(np.moveaxis(own, -1, 0)[:, None], (len(points.positions), 8, LEAVES, LEAVES))}
    return found | {SWEPT[kind]: corners.of_grid(grid.values) for kind, grid in grids.items()}, grids["half-angle"]


class Experiment:
    def __init__(self, count, fine, seed):
        self.count, self.fine, self.seed = count, fine, seed
        self.variances, self.worst = {}, 0.0  # {(scene, light, epsilon): {variant: [points]}}; of the self-check

    def add(self, scene, lights):
        rng = np.random.default_rng(self.seed)
        session = scenes.open_session(scene, lights[0], width=64, seed=self.seed)
        volume, transfer_function = session.volume, session.transfer_function
        points = Points(session, self.count, rng)
        corners = Corners(volume, points.positions, CELL)
        exact = lumisweep.transmittance(volume, transfer_function, points.positions[:, None, None],
                                        lumisweep.octahedral_directions(self.fine), reference="exact")
        found, grid = visibilities(volume, transfer_function, points, corners, exact, rng)
        for light_name in lights:
            environment = scenes.parts(scene, light_name)[3]
            light = Light(environment, self.fine, LEAVES)
            for epsilon in EPSILONS:
                densities = {name: leaf_density(corners, v, light, epsilon) for name, v in found.items()}
                densities[ENVIRONMENT] = np.broadcast_to(light.leaf / light.leaf.mean(), densities[FLOAT].shape)
                self.variances[scene, light_name, epsilon] = {name: variance(exact, light, density, points.albedo)
                                                              for name, density in densities.items()}
                self.worst = max(self.worst, check_density(volume, environment, grid, corners, points.positions, light, epsilon))
        if self.worst > 1e-4:
            raise StudyError(f"{scene}: the study's density differs from the sampler's by {self.worst:.2g}")

    def ratio(self, case, name, base):
        """Of the points' variances summed, as in an image, and its standard error over points: they are paired."""
        a, b = self.variances[case][name], self.variances[case][base]
        value = a.sum() / b.sum()
        return value, np.std(a - value * b, ddof=1) / (b.mean() * np.sqrt(len(b)))

    def mean_ratio(self, epsilon, name, base):
        """Geometric mean over scenes and lights; the lights of a scene share their points, so errors are added within it."""
        each = [(case[0], *self.ratio(case, name, base)) for case in self.variances if case[2] == epsilon]
        of_scene = {}
        for scene, value, error in each:
            of_scene[scene] = of_scene.get(scene, 0) + error / value
        value = float(np.exp(np.mean([np.log(value) for _, value, _ in each])))
        return value, value * float(np.hypot.reduce(list(of_scene.values()))) / len(each)

    def rows(self):
        return [{"scene": scene, "light": light, "epsilon": epsilon, "ratio": text, "value": value, "error": error}
                for scene, light, epsilon in self.variances for text, name, base in RATIOS
                for value, error in [self.ratio((scene, light, epsilon), name, base)]]

    def table(self, epsilon):
        cases = [case for case in self.variances if case[2] == epsilon]
        rows = [[text, *[with_error(*self.ratio(case, name, base), 4) for case in cases],
                 with_error(*self.mean_ratio(epsilon, name, base), 4)] for text, name, base in RATIOS]
        return markdown_rows([f"ε = {epsilon:g}", *[f"{scene}, {light}" for scene, light, _ in cases], "geometric mean"], rows)

    def findings(self):
        """What the tables say, in words that follow from them."""
        lines = []
        for epsilon in EPSILONS:
            both = {text: self.mean_ratio(epsilon, name, base) for text, name, base in RATIOS}
            bits, bits_error = both["8 bits / float"]
            seen = "no difference seen" if abs(bits - 1) < max(0.005, 2 * bits_error) else "which shows"
            classified, error = both["classified first / interpolated first"]
            which = ("makes no difference that is seen" if abs(classified - 1) < max(0.005, 2 * error) else
                     f"costs {100 * (classified - 1):.2g} %" if classified > 1 else f"saves {100 * (1 - classified):.2g} %")
            lines.append(f"""ε = {epsilon:g}: rounding V to 8 bits leaves {with_error(bits, bits_error)} of the variance,
{seen}. To classify voxels to 8 bits and interpolate then, as sweeps do, {which} against interpolating first, as the renderer
does ({with_error(classified, error)}). Sweeps without a filter leave {with_error(*both['swept without a filter / centres'])} of
what one exact ray a cell and direction leaves, with the half angle {with_error(*both['swept, half angle / centres'])}.""")
        return plots.prose("\n\n".join(lines), "- ")

    def report(self):
        text = ["## 8 bits and classification, at single points", plots.prose(f"""
            The grid has 8 bits, so floating point cannot be rendered with. Here two-step's density is built from any V, at up to
            {self.count} first collisions of camera rays a scene (seed {self.seed}), and the variance of V L / p there is summed
            over a map of {self.fine}² directions with V exact and the light at full resolution. V's own estimate by shadow rays
            and what differs between points are left out, so that settings differ more than in images. Ratios of variances, summed
            over points as pixels are; ± is the standard error over points. The density agrees with the sampler's own
            (`DirectionSampler.pdf_map`) to {self.worst:.1g}."""), self.findings(), plots.prose(f"""
            Centres: one exact ray from the cell's centre towards the texel's, through the volume that is classified to 8 bits
            first as sweeps have it, or interpolated first and then classified. Mean over cell and texel: of {RAYS_TO_AVERAGE}
            random rays, what the filter aims at. The point's own: what no cell, however small, could improve on by its place.
            Environment sampling, for comparison, needs no V."""), *[self.table(epsilon) for epsilon in EPSILONS]]
        return "\n\n".join(text)


def experiment(scene_names, lights, count, fine, seed=1):
    found = Experiment(count, fine, seed)
    for scene in scene_names:
        found.add(scene, lights)
    return found

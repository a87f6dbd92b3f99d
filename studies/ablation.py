#!/usr/bin/python3
"""What each setting of two-step sampling is worth, and what it costs: docs/results/ablation.md.

Epsilon, directions, cells, filter, rays and oversampling by renders at equal samples, with the same random numbers for every
setting, so that ratios are sharper than the errors themselves. Visibility in 8 bits against floating point, and classified
before against after interpolation, by exact variances at single points (densities.py). About seven minutes.

    studies/ablation.py [--quick]
"""
import argparse
import dataclasses
import math

import numpy as np

import densities
import measure
import plots
import scenes
from common import markdown_rows, mean_and_error, with_error
from scenes import lumisweep

SCENES, LIGHTS = ["ct_head", "stent", "plume"], ["courtyard", "sunrise"]
FILTERS = ["none", "half-angle", "full-angle"]
EPSILONS = [0.001, 0.01, 0.03, 0.1, 0.3]
PAPERS_EPSILON = 0.01


# --- settings, measured: other studies take them from here ----------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class Setting:
    """lumisweep.VisibilitySettings that can be compared and listed, with the same defaults."""
    filter: str = "half-angle"
    epsilon: float = 0.1
    cell: int = 4
    directions: int = 8
    rays: object = "auto"
    oversampling: int = 1

    def visibility(self):
        return lumisweep.VisibilitySettings(**dataclasses.asdict(self))


DEFAULT = Setting()


def errors(session, settings, reference, samples, seeds, keep=lambda setting, image: None):
    """{setting: squared errors, one a seed}: paired, as every setting gets the same seeds. `keep` sees the first seed's image."""
    measured = {}
    for setting in settings:
        session.visibility_settings = setting.visibility()
        measured[setting] = []
        for seed in seeds:
            session.render_settings = session.render_settings.replace(seed=seed)
            image = session.render(samples=samples)
            measured[setting].append(measure.squared_error(image, reference))
            if seed == seeds[0]:
                keep(setting, image)
    return measured


def seeds_of(case, count):
    """Of the case of that index: every case has its own, so that errors over cases are independent."""
    return range(1 + case * count, 1 + (case + 1) * count)


def relative(values, base):
    """Mean logarithm of the ratio of paired errors and its standard error over seeds."""
    return mean_and_error([math.log(a / b) for a, b in zip(values, base)])


def mean_relative(cases, setting, base):
    """The same, geometric mean over cases; its error is of the seeds, not of the choice of scenes."""
    each = [relative(measured[setting], measured[base]) for measured in cases]
    return sum(value for value, _ in each) / len(each), math.sqrt(sum(error ** 2 for _, error in each)) / len(each)


def ratio_text(logarithm, error):
    value = math.exp(logarithm)
    return with_error(value, value * error)


def sweep_cost(scene, light, setting, repeats=3):
    """(seconds of one thread, the least of several; bytes of V; rays along the longer side)."""
    volume, transfer_function = scenes.parts(scene, light)[:2]
    runs = [lumisweep.sweep_visibility(volume, transfer_function, setting.visibility(), threads=1) for _ in range(repeats)]
    return min(run.stats["seconds"]["sweep"] for run in runs), runs[0].values.nbytes, runs[0].stats["rays"]


# --- this study -----------------------------------------------------------------------------------------------------------

GROUPS = {
    "Epsilon and filter": [Setting(filter=kind, epsilon=epsilon) for kind in FILTERS for epsilon in EPSILONS],
    # 32² directions of cells of 2³ voxels would take 32 times the volume's size.
    "Cells and directions": [Setting(cell=cell, directions=n) for cell in (2, 4, 8, 16) for n in (4, 8, 16, 32)
                             if cell > 2 or n < 32],
    "Cells and filter": [Setting(cell=cell, filter=kind) for cell in (2, 4, 8, 16) for kind in FILTERS],
    "Rays and filter": [Setting(rays=rays, filter=kind) for rays in ("auto", 128, 64) for kind in FILTERS],
    "Oversampling": [DEFAULT, *(Setting(filter=kind, oversampling=times) for kind, times in
                                (("none", 1), ("none", 4), ("none", 16), ("half-angle", 4)))],
}


def all_settings():
    return list(dict.fromkeys([DEFAULT, *(setting for group in GROUPS.values() for setting in group)]))


def name(setting):
    """What differs from the default."""
    parts = [f"ε = {setting.epsilon:g}" if setting.epsilon != DEFAULT.epsilon else "",
             f"filter {setting.filter}" if setting.filter != DEFAULT.filter else "",
             f"{setting.oversampling}× directions" if setting.oversampling > 1 else "",
             f"cells of {setting.cell}³" if setting.cell != DEFAULT.cell else "",
             f"{setting.directions}² directions" if setting.directions != DEFAULT.directions else "",
             f"{setting.rays}² rays" if setting.rays != DEFAULT.rays else ""]
    return ", ".join(part for part in parts if part) or "default"


def group_table(settings, measured, costs, size):
    rows = []
    for setting in settings:
        overall = "1" if setting == DEFAULT else ratio_text(*mean_relative(measured.values(), setting, DEFAULT))
        # What a sweep costs does not depend on epsilon.
        swept = dataclasses.replace(setting, epsilon=DEFAULT.epsilon)
        rows.append([name(setting), *[f"{math.exp(relative(case[setting], case[DEFAULT])[0]):.2f}" for case in measured.values()],
                     overall,
                     " / ".join(f"{1000 * costs[scene, swept][0]:.3g}" for scene in size),
                     " / ".join(f"{costs[scene, swept][1] / size[scene]:.2g}" for scene in size)])
    return markdown_rows(["setting", *[f"{scene}, {light}" for scene, light in measured], "geometric mean", "sweep, ms",
                          "V, bytes a voxel"], rows)


def findings(measured):
    """What the tables say, in words that follow from them."""
    def against(setting, base):
        return ratio_text(*mean_relative(measured.values(), setting, base))

    lines = []
    for kind in FILTERS:
        least = min(EPSILONS, key=lambda e: mean_relative(measured.values(), Setting(filter=kind, epsilon=e), DEFAULT)[0])
        of_ours = "" if least == DEFAULT.epsilon else (
            f", {against(Setting(filter=kind, epsilon=least), Setting(filter=kind))} of that of our ε = {DEFAULT.epsilon:g}")
        lines.append(f"""Filter {kind}: ε = {least:g} has the least error of those tried{of_ours}; the papers'
            ε = {PAPERS_EPSILON:g} leaves {against(Setting(filter=kind, epsilon=PAPERS_EPSILON), Setting(filter=kind))} of the
            error of our ε = {DEFAULT.epsilon:g}.""")
    for epsilon in (PAPERS_EPSILON, DEFAULT.epsilon):
        half, full = (against(Setting(filter=kind, epsilon=epsilon), Setting(filter="none", epsilon=epsilon))
                      for kind in FILTERS[1:])
        lines.append(f"At ε = {epsilon:g} the half angle leaves {half} of the error without a filter, the full angle {full}.")
    best = min(all_settings(), key=lambda s: mean_relative(measured.values(), s, DEFAULT)[0])
    lines.append(f"""For four times the memory, 16² directions leave {against(Setting(directions=16), DEFAULT)} of the default's
error; for eight times, cells of 2³ voxels leave {against(Setting(cell=2), DEFAULT)}. Cells of 8³, an eighth of the memory:
{against(Setting(cell=8), DEFAULT)}; 4² directions, a quarter: {against(Setting(directions=4), DEFAULT)}.""")
    lines.append(f"""The least error of all {len(all_settings())} settings here: {name(best)}, {against(best, DEFAULT)} of the
default's; as the least of many it is a little flattered.""")
    return plots.prose("\n\n".join(lines), "- ")


def plot(measured, costs, scene_names, path):
    figure, (left, middle, right) = plots.plt.subplots(1, 3, figsize=(9, 2.9), constrained_layout=True)

    def line(axes, x, settings, label):
        points = [mean_relative(measured.values(), setting, DEFAULT) for setting in settings]
        values = np.exp([value for value, _ in points])
        axes.errorbar(x, values, values * [2 * error for _, error in points], marker="o", markersize=3, capsize=2, label=label)

    for kind in FILTERS:
        line(left, EPSILONS, [Setting(filter=kind, epsilon=epsilon) for epsilon in EPSILONS], kind)
    left.axvline(PAPERS_EPSILON, color="#888888", linestyle=":", linewidth=1)
    left.set(xscale="log", xlabel="ε (dotted: the papers')", ylabel="squared error / default's")
    for cell in (2, 4, 8, 16):
        settings = [setting for setting in GROUPS["Cells and directions"] if setting.cell == cell]
        line(middle, [setting.directions for setting in settings], settings, f"cells of {cell}³")
    middle.set(xscale="log", xlabel="directions a side")
    middle.set_xticks([4, 8, 16, 32], ["4²", "8²", "16²", "32²"])
    middle.minorticks_off()
    for index, (group, settings) in enumerate(GROUPS.items()):
        settings = [setting for setting in settings if setting.epsilon == DEFAULT.epsilon]
        seconds = [np.exp(np.mean([math.log(costs[scene, setting][0]) for scene in scene_names])) for setting in settings]
        right.scatter(np.array(seconds) * 1000, [math.exp(mean_relative(measured.values(), s, DEFAULT)[0]) for s in settings],
                      s=10, marker="os^Dv"[index], label=group)
    right.set(xscale="log", xlabel="sweep, ms of one thread (mean over scenes)")
    for axes in (left, middle, right):
        axes.legend()
    plots.save(figure, path)


def main():
    options = plots.parse(argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter))
    quick = options.quick
    scene_names, lights = (scenes.QUICK_SCENES, [scenes.QUICK_LIGHT]) if quick else (SCENES, LIGHTS)
    width, samples, seeds, reference_samples = (32, 8, 2, 64) if quick else (128, 64, 3, 1024)
    points, fine = (16, 16) if quick else (250, 64)
    scenes.need(scene_names, lights)

    measured, costs, size, own = {}, {}, {}, []
    for scene in scene_names:
        size[scene] = math.prod(scenes.parts(scene, lights[0])[0].shape)
        plots.progress(f"{scene}: sweeps")
        swept = {dataclasses.replace(setting, epsilon=DEFAULT.epsilon) for setting in all_settings()}
        costs.update({(scene, setting): sweep_cost(scene, lights[0], setting, 1 if quick else 3) for setting in swept})
        for light in lights:
            plots.progress(f"{scene} under {light}")
            reference = measure.reference(scene, light, width, reference_samples, options.cache)
            session = scenes.open_session(scene, light, width=width)
            measured[scene, light] = errors(session, all_settings(), reference, samples, seeds_of(len(measured), seeds))
            own.append(reference.variance / np.mean(measured[scene, light][DEFAULT]))
    plots.progress("variances at points")
    exact = densities.experiment(scene_names, lights, points, fine)

    plot(measured, costs, scene_names, options.output / "ablation.svg")
    plots.write_csv(options.output / "ablation.csv", [
        {"scene": scene, "light": light, **dataclasses.asdict(setting), "seed": seed, "mse": error}
        for index, ((scene, light), case) in enumerate(measured.items()) for setting, values in case.items()
        for seed, error in zip(seeds_of(index, seeds), values)])
    plots.write_csv(options.output / "ablation-densities.csv", exact.rows())

    reference_text = (f"{reference_samples} samples of auto, seed {measure.REFERENCE_SEED}, whose own variance is taken off: at "
                      f"most {100 * max(own):.2g} % of what is measured with the default")
    defaults = [[f"{scene}, {light}", with_error(*mean_and_error(case[DEFAULT]))] for (scene, light), case in measured.items()]
    text = ["# Two-step sampling, setting by setting", plots.prose(f"""
        Squared error at {samples} samples a pixel over that of the default (ε = {DEFAULT.epsilon:g}, {DEFAULT.filter} filter,
        cells of {DEFAULT.cell}³ voxels, {DEFAULT.directions}² directions, every voxel a ray); below 1 is better. {width} ×
        {width} pixels, background hidden. Every setting has the same random numbers; ± is the standard error over seeds, also of
        the geometric means. The smaller ε, the rarer and larger are samples in directions taken for hidden: what few renders may
        miss ± does not know. Beside them, for {' / '.join(scene_names)}: one thread's time for the sweep and the grid's memory.
        The defaults were chosen on scenes that are among these."""), plots.header(
            "ablation", options, f"Seeds 1 to {seeds * len(measured)}, {seeds} for each scene and light.", reference_text),
        "![Epsilon, directions and cells, cost](ablation.svg)", "Error bars are two standard errors.",
        markdown_rows(["scene", f"MSE at {samples}, default"], defaults), "## What follows", findings(measured)]
    for group, settings in GROUPS.items():
        text += [f"## {group}", group_table(settings, measured, costs, size)]
    text.append(exact.report())
    (options.output / "ablation.md").write_text("\n\n".join(text) + "\n")
    print(f"Report: {options.output / 'ablation.md'}")
    return 0


if __name__ == "__main__":
    plots.run(main)

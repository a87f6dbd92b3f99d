#!/usr/bin/python3
"""The sweep-space filter against oversampling and against none (journal paper, Figures 6 and 8): docs/results/sweep-filter.md.

At the papers' ε and at ours, since the filter is worth something else at each. About five minutes.

    studies/sweep_filter.py [--quick]
"""
import argparse
import dataclasses
import math

import numpy as np

import measure
import plots
import scenes
from ablation import DEFAULT, PAPERS_EPSILON, Setting, errors, mean_relative, ratio_text, relative, seeds_of, sweep_cost
from common import markdown_rows, mean_and_error, with_error

LIGHTS = ["courtyard", "sunrise"]
EPSILONS = [PAPERS_EPSILON, DEFAULT.epsilon]
NONE, HALF, FULL = "unfiltered", "half angle", "full angle"
ENVIRONMENT = "environment"
# Setting of ε = our default by name; each is also taken at the papers'.
METHODS = {NONE: Setting(filter="none"), "4× directions": Setting(filter="none", oversampling=4),
           "16× directions": Setting(filter="none", oversampling=16), HALF: Setting(), FULL: Setting(filter="full-angle")}
# Environment sampling reads no visibility: any setting will do.
ENVIRONMENT_SETTING = DEFAULT
# Journal paper, Figure 8: MSE × 1000 of its two images.
PAPERS_SMOOTH = {ENVIRONMENT: (10.45, 6.77), NONE: (7.29, 4.58), HALF: (5.8, 4.53), FULL: (7.32, 5.16)}


@dataclasses.dataclass(frozen=True)
class Part:
    """One of the papers' figures."""
    figure: int
    name: str
    scenes: tuple
    methods: tuple
    samples: int


PARTS = [Part(6, "hard", ("ct_head", "stent"), tuple(METHODS), 64),
         Part(8, "smooth", ("plume", "cloud"), (NONE, HALF, FULL), 32)]
QUICK_PARTS = [dataclasses.replace(PARTS[0], scenes=("generated",)), dataclasses.replace(PARTS[1], scenes=("plume",))]


def at(method, epsilon):
    return dataclasses.replace(METHODS[method], epsilon=epsilon)


class Measured:
    """Errors by case and setting, the first seed's images, and the environment's errors where the figure has them."""

    def __init__(self, part, lights, width, seeds, reference_samples, cache):
        self.part, self.width = part, width
        self.errors, self.environment, self.images, self.references, self.seeds = {}, {}, {}, {}, {}
        settings = [at(method, epsilon) for epsilon in EPSILONS for method in part.methods]
        for scene in part.scenes:
            for light in lights:
                plots.progress(f"{scene} under {light}")
                case = scene, light
                self.seeds[case] = seeds_of(len(self.seeds), seeds)
                self.references[case] = measure.reference(scene, light, width, reference_samples, cache)
                session = scenes.open_session(scene, light, width=width)

                def keep(setting, image, case=case):
                    self.images[case, setting] = np.array(image.radiance)

                self.errors[case] = errors(session, settings, self.references[case], part.samples, self.seeds[case], keep)
                if part.name == "smooth":
                    session = scenes.open_session(scene, light, width=width, strategy="environment")
                    self.environment[case] = errors(session, [ENVIRONMENT_SETTING], self.references[case], part.samples,
                                                    self.seeds[case], keep)[ENVIRONMENT_SETTING]

    def own_share(self):
        """The largest part of the reference's own variance in what was measured."""
        return max(self.references[case].variance / mean_and_error(values)[0]
                   for case, of_case in self.errors.items() for values in of_case.values())

    def share_of_worst(self, method, epsilon):
        """What the worst hundredth of the pixels has of the squared error, mean over cases."""
        return np.mean([measure.share_of_worst(self.images[case, at(method, epsilon)], self.references[case], 0.01)
                        for case in self.errors])

    def ratio(self, method, epsilon, base=NONE):
        return mean_relative(self.errors.values(), at(method, epsilon), at(base, epsilon))

    def environment_ratio(self, epsilon):
        each = [relative(values, self.errors[case][at(NONE, epsilon)]) for case, values in self.environment.items()]
        return np.mean([value for value, _ in each]), math.sqrt(sum(error ** 2 for _, error in each)) / len(each)


# --- report ---------------------------------------------------------------------------------------------------------------

def table(measured, epsilon, costs):
    part = measured.part
    rows = []
    if measured.environment:
        rows.append([ENVIRONMENT, *[with_error(*mean_and_error(values)) for values in measured.environment.values()],
                     ratio_text(*measured.environment_ratio(epsilon)), papers_text(ENVIRONMENT, part), "–", "–"])
    for method in part.methods:
        setting = at(method, epsilon)
        rows.append([method, *[with_error(*mean_and_error(of_case[setting])) for of_case in measured.errors.values()],
                     "1" if method == NONE else ratio_text(*measured.ratio(method, epsilon)), papers_text(method, part),
                     f"{100 * measured.share_of_worst(method, epsilon):.0f} %",
                     " / ".join(f"{1000 * costs[scene, METHODS[method]]:.3g}" for scene in part.scenes)])
    return markdown_rows([f"ε = {epsilon:g}", *[f"{scene}, {light}" for scene, light in measured.errors], "ratio to unfiltered",
                          "the papers' ratio", "error in the worst 1 % of pixels", "sweep, ms"], rows)


def papers_text(method, part):
    if part.figure != 8 or method not in PAPERS_SMOOTH:
        return "–"
    return " / ".join(f"{a / b:.2f}" for a, b in zip(PAPERS_SMOOTH[method], PAPERS_SMOOTH[NONE]))


def more_than_noise(logarithm, error):
    return abs(logarithm) > max(0.01, 2 * error)


def seen(logarithm, error):
    """A ratio, and whether it is more than the noise of measuring it."""
    verdict = "no difference seen" if not more_than_noise(logarithm, error) else "less" if logarithm < 0 else "more"
    return f"{ratio_text(logarithm, error)} ({verdict})"


def csv_rows(measured):
    of_strategies = [("two-step", case, setting, values) for case, of_case in measured.errors.items()
                     for setting, values in of_case.items()]
    of_strategies += [(ENVIRONMENT, case, ENVIRONMENT_SETTING, values) for case, values in measured.environment.items()]
    return [{"scene": scene, "light": light, "strategy": strategy, **dataclasses.asdict(setting), "seed": seed, "mse": error}
            for strategy, (scene, light), setting, values in of_strategies
            for seed, error in zip(measured.seeds[scene, light], values)]


def findings(hard, smooth):
    lines = []
    for epsilon in EPSILONS:
        times = ("4× directions", "16× directions")
        against = hard.ratio(HALF, epsilon, times[1])
        ahead = "we see no difference" if not more_than_noise(*against) else "so do we" if against[0] < 0 else "we do not"
        lines.append(f"""Hard visibility, ε = {epsilon:g}: of the error without a filter the half angle leaves
            {seen(*hard.ratio(HALF, epsilon))}, the full angle {seen(*hard.ratio(FULL, epsilon))}, 4× directions
            {seen(*hard.ratio(times[0], epsilon))} and 16× directions {seen(*hard.ratio(times[1], epsilon))}. The papers see the
            filter ahead of 16× directions: {ahead}; the half angle leaves
            {seen(*hard.ratio(HALF, epsilon, times[0]))} of the error of 4×, {seen(*hard.ratio(HALF, epsilon, times[1]))} of that
            of 16×.""")
    for epsilon in EPSILONS:
        lines.append(f"""Smooth visibility, ε = {epsilon:g}: of the error without a filter the half angle leaves
            {seen(*smooth.ratio(HALF, epsilon))}, the full angle {seen(*smooth.ratio(FULL, epsilon))} and environment sampling
            {seen(*smooth.environment_ratio(epsilon))}; the papers' two images have {papers_text(HALF, smooth.part)},
            {papers_text(FULL, smooth.part)} and {papers_text(ENVIRONMENT, smooth.part)}.""")
    low, high = EPSILONS
    (at_low, low_error), (at_high, high_error) = (hard.ratio(HALF, epsilon) for epsilon in EPSILONS)
    share = {epsilon: 100 * hard.share_of_worst(NONE, epsilon) for epsilon in EPSILONS}
    if at_low < 0 and more_than_noise(at_low - at_high, math.hypot(low_error, high_error)) and share[low] > share[high] + 1:
        lines.append(f"""Why the filter is worth more at the smaller ε: where V of a cell is 0 and a part of the cell is lit, the
            density there is ε times the light's, and the rare hit weighs 1 / ε. Unfiltered, the worst hundredth of the pixels has
            {share[low]:.0f} % of the squared error at ε = {low:g} and {share[high]:.0f} % at ε = {high:g}. The filter and a
            larger ε both lift such zeros, and what one has done the other need not: the half angle leaves
            {math.exp(at_low):.2f} of the unfiltered error at the one and {math.exp(at_high):.2f} at the other.""")
    if any(more_than_noise(*smooth.ratio(HALF, epsilon)) and smooth.ratio(HALF, epsilon)[0] > 0 for epsilon in EPSILONS):
        lines.append("""Why it can cost: V lies at the cells' centres and is interpolated between them, which is an average
            already, and where V varies smoothly it is a good one. The filter averages over the cell before that, and both
            together blur more than is needed.""")
    return plots.prose("\n\n".join(lines), "- ")


def difference(image, reference):
    """|image − reference|, mean over R, G and B, as 8-bit grey; white is half of the reference's 99th percentile."""
    bright = np.percentile(reference @ measure.LUMINANCE, 99)
    grey = 255 * np.clip(2 * np.abs(image - reference).mean(axis=2) / bright, 0, 1)
    return np.repeat(np.round(grey).astype(np.uint8)[..., None], 3, axis=2)


def picture(measured, case, path):
    """Reference first, then every method at both ε, with its difference from the reference below."""
    part, reference = measured.part, measured.references[case].radiance
    settings = [at(method, epsilon) for epsilon in EPSILONS for method in part.methods]
    shown = plots.display([reference, *[measured.images[case, setting] for setting in settings]], reference)
    by_setting = dict(zip(settings, shown[1:]))
    tile = reference.shape[0] * max(1, round(192 / reference.shape[0]))
    gap, title = 4, 14
    block = title + 2 * (tile + gap)
    canvas = plots.Canvas((tile + gap) * (1 + len(part.methods)), block * len(EPSILONS))
    canvas.image(shown[0], 0, title, (tile, tile))
    canvas.text(f"{case[0]} under {case[1]}, reference", 0, 1)
    light = plots.latlong(scenes.parts(*case)[3], tile // 2)
    canvas.image(plots.display([light])[0], 0, title + tile + gap, (tile, tile // 2))
    for row, epsilon in enumerate(EPSILONS):
        top = row * block + title
        for column, method in enumerate(part.methods, 1):
            setting, left = at(method, epsilon), column * (tile + gap)
            canvas.text(f"{method}, ε = {epsilon:g}", left, top - title + 1)
            canvas.image(by_setting[setting], left, top, (tile, tile))
            canvas.image(difference(measured.images[case, setting], reference), left, top + tile + gap, (tile, tile))
            canvas.text(f"MSE {measured.errors[case][setting][0]:.2e}", left + 4, top + tile + gap + 4, color="white")
    plots.save(canvas.figure, path)


def main():
    options = plots.parse(argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter))
    quick = options.quick
    parts, lights = (QUICK_PARTS, [scenes.QUICK_LIGHT]) if quick else (PARTS, LIGHTS)
    width, seeds, reference_samples = (48, 2, 128) if quick else (192, 4, 1024)
    scenes.need([scene for part in parts for scene in part.scenes], lights)
    both = [Measured(part, lights, width, seeds, reference_samples, options.cache) for part in parts]
    costs = {(scene, METHODS[method]): sweep_cost(scene, lights[0], METHODS[method])[0]
             for part in parts for scene in part.scenes for method in part.methods}

    texts, rows = [], []
    for measured in both:
        part = measured.part
        pictures = []
        for case in measured.errors:
            if case[1] == lights[0]:
                picture(measured, case, options.output / f"sweep-filter-{case[0]}.png")
                pictures.append(f"![{case[0]} under {case[1]}](sweep-filter-{case[0]}.png)")
        texts.append("\n\n".join([f"## Figure {part.figure}: {part.name} visibility", f"Squared error at {part.samples} samples.",
                                  *[table(measured, epsilon, costs) for epsilon in EPSILONS], *pictures]))
        rows += csv_rows(measured)
    plots.write_csv(options.output / "sweep-filter.csv", rows)
    own = max(measured.own_share() for measured in both)
    reference_text = (f"{reference_samples} samples of auto, seed {measure.REFERENCE_SEED}; their own variance is taken off, at "
                      f"most {100 * own:.2g} % of what is measured")
    text = ["# The sweep-space filter", plots.prose(f"""
        The journal paper's Figures 6 and 8 on public data: two-step sampling with visibility unfiltered, oversampled in direction
        and filtered, at the papers' ε = {PAPERS_EPSILON:g} and at our default ε = {DEFAULT.epsilon:g}. {width} × {width} pixels,
        background hidden, cells of {DEFAULT.cell}³ voxels, {DEFAULT.directions}² directions. All settings have the same random
        numbers: ratios are geometric means over scenes and lights of ratios at equal seeds, ± the standard error over seeds. Half
        angle is β = π/32, half of a texel's half opening angle; full angle π/16."""),
        plots.header("sweep_filter", options, f"""Seeds 1 to {seeds * max(len(measured.errors) for measured in both)}, {seeds} for
            each scene and light of a figure; pictures show the first of them.""", reference_text), findings(*both),
        *texts, plots.prose(f"""
        In the pictures the lower rows are the difference from the reference, mean over R, G and B of |image − reference|, white
        at half of the reference's 99th percentile. Sweep: one thread, the least of three, for
        {' and '.join(' / '.join(part.scenes) for part in parts)}.""")]
    (options.output / "sweep-filter.md").write_text("\n\n".join(text) + "\n")
    print(f"Report: {options.output / 'sweep-filter.md'}")
    return 0


if __name__ == "__main__":
    plots.run(main)

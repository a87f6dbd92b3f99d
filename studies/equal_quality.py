#!/usr/bin/python3
"""The papers' comparison at equal quality (conference figure 7): samples and time that every strategy needs for the same error.

Writes equal-quality.md, .csv and .png. About four minutes on two cores, two of them for references that other studies
use, too.

    studies/equal_quality.py [--quick] [--target-samples 32] [--output DIR] [--cache DIR]
"""
import argparse
import math
import time
from statistics import mean

import plots
from common import markdown_rows, with_error
from measure import describe, interval_reach, radiance_of, references, squared_error
from scenes import PAPERS, STRATEGIES, figure_places, open_session

SEEDS = (1, 2, 3)


# --- measuring ------------------------------------------------------------------------------------------------------------

def doubling(session, known, most, target, images):
    """[(samples, squared error, seconds)] at powers of two, until the error is well below the target or there are `most`."""
    session.prepare()
    curve, seconds, samples = [], 0.0, 1
    while samples <= most:
        begin = time.process_time()
        image = session.render(samples=samples)
        seconds += time.process_time() - begin
        curve.append((samples, squared_error(image, known), seconds))
        images.setdefault(samples, radiance_of(image))
        if target is not None and curve[-1][1] < target / 2:
            break
        samples *= 2
    return curve


def needed(curve, target):
    """(samples, seconds) from which on the error stays below the target.

    Straight lines between powers of two in logarithms, beyond them a slope of −1.
    """
    logs = [(math.log(n), math.log(error)) for n, error, _ in curve if error > 0]
    above = [index for index, (_, y) in enumerate(logs) if y > math.log(target)]
    if above and above[-1] + 1 < len(logs):
        (x0, y0), (x1, y1) = logs[above[-1]:above[-1] + 2]
        samples = math.exp(x0 + (x1 - x0) * (y0 - math.log(target)) / (y0 - y1))
    else:
        x, y = logs[-1] if above else logs[0]
        samples = math.exp(x + y - math.log(target))
    return samples, samples * curve[-1][2] / curve[-1][0]


def closest(curve, target):
    """The power of two whose error is closest to the target, by ratio."""
    return min((point for point in curve if point[1] > 0), key=lambda point: abs(math.log(point[1] / target)))


def measure(scene, light, known, options):
    curves, pictures, target = {}, {}, None
    for name in ["two-step", *(name for name in STRATEGIES if name != "two-step")]:
        plots.progress(f"{scene} under {light}: {name}")
        images = {}
        session = open_session(scene, light, width=options.width, strategy=name)
        curves[name] = []
        for seed in SEEDS:
            session.render_settings = session.render_settings.replace(seed=seed)
            most = options.target_samples * 2 if target is None else options.most_samples
            curves[name].append(doubling(session, known, most, target, images))
        if target is None:
            target = sum(error for curve in curves[name] for n, error, _ in curve if n == options.target_samples) / len(SEEDS)
        shown = closest(curves[name][0], target)
        pictures[name] = (images[shown[0]], shown)
    return {"target": target, "curves": {name: curves[name] for name in STRATEGIES}, "pictures": pictures}


# --- reporting ------------------------------------------------------------------------------------------------------------

def seeds_needed(found, name):
    """Samples and seconds of the seeds, and whether the last error was still above the target."""
    each = [needed(curve, found["target"]) for curve in found["curves"][name]]
    return list(zip(*each)), any(curve[-1][1] > found["target"] for curve in found["curves"][name])


def amount(values, beyond):
    """With half of the 95 % interval; what is continued beyond the samples as its range over seeds."""
    return f"≈ {min(values):.3g} to {max(values):.3g}" if beyond else with_error(mean(values), interval_reach(values))


def table(found):
    rows = []
    environment, environment_beyond = seeds_needed(found, "environment")
    for name in STRATEGIES:
        (samples, seconds), beyond = seeds_needed(found, name)
        shown = found["pictures"][name][1]
        mark = "≈ " if beyond or environment_beyond else ""
        rows.append([name, str(shown[0]), f"{shown[1]:.3g}", amount(samples, beyond), amount(seconds, beyond),
                     f"{mark}{mean(samples) / mean(environment[0]):.3g}", f"{mark}{mean(seconds) / mean(environment[1]):.3g}"])
    return markdown_rows(["strategy", "SPP, power of two", "its MSE", "samples for the target", "processor time, s",
                          "samples / environment's", "time / environment's"], rows)


def least(amounts):
    """The name of the smallest mean, and with it those whose difference from it is less than its 95 % interval over seeds."""
    ordered = sorted(amounts, key=lambda name: mean(amounts[name]))
    first = amounts[ordered[0]]

    def told_apart(name):
        differences = [a - b for a, b in zip(amounts[name], first)]
        return mean(differences) > interval_reach(differences)

    return " or ".join([ordered[0], *(name for name in ordered[1:] if not told_apart(name))])


def words(results):
    lines = []
    for (scene, light), found in results.items():
        amounts = {name: seeds_needed(found, name) for name in STRATEGIES}
        far = [name for name in STRATEGIES if amounts[name][1]]
        fewest = least({name: amounts[name][0][0] for name in PAPERS if name not in far})
        quickest = least({name: amounts[name][0][1] for name in STRATEGIES if name not in far})
        against = mean(amounts["environment"][0][0]) / mean(amounts["two-step"][0][0])
        lines.append(plots.prose(f"""**{scene} under {light}**: the fewest samples of the papers' five: {fewest}; environment
            sampling needs {against:.2f} times two-step's. The least processor time of all six: {quickest}.""", "- "))
        if far:
            most = max(curve[-1][0] for name in far for curve in found["curves"][name])
            lines.append(plots.prose(f"""Not reached by all seeds within {most} samples, and told by a slope of −1:
                {', '.join(far)}.""", "  - "))
    if any(" or " in line for line in lines):
        lines.append(plots.prose(f"“Or” stands between what {len(SEEDS)} seeds do not tell apart.", "- "))
    lines.append(plots.prose(f"""
        **The paper** says that two-step “requires significantly less samples” and prints its counts inside the figure alone:
        its text has no number to lay beside ours. What ours says depends on how much light is hidden and on the lamps in it,
        which directions that do not know them meet rarely (`equal-time.md`).

        **Samples are not time.** A sample of auto is three shadow rays, and costs accordingly: compare the columns of time.
        """, "- "))
    return "\n".join(lines)


def report(options, known, results):
    about = plots.prose(f"""
        Conference paper, figure 7: the target is the mean squared error of two-step sampling at {options.target_samples}
        samples a pixel, and every strategy shows the power of two that comes closest to it. How many samples the target takes
        is read from the errors at powers of two, on straight lines between their logarithms; ± is half of the 95 % interval
        over {len(SEEDS)} seeds. ≈: not reached by all of them, continued with a slope of −1, with the range over seeds.
        Processor time is that of the passes over all threads, without majorants, sweep and joint grid. {options.width} ×
        {options.width} pixels, background hidden; the reference's own variance is taken off.

        {plots.header("equal_quality", options, f"Seeds {', '.join(map(str, SEEDS))}.", describe(known))}

        ![images of about the same error](equal-quality.png)
        """)
    text = ["# Equal quality", about, "## Where ours differs from the paper's, and why", words(results)]
    text += [f"## {scene} under {light}: MSE {found['target']:.3g}\n\n{table(found)}"
             for (scene, light), found in results.items()]
    return "\n\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-samples", type=int, default=None, help="of two-step sampling, a power of two (32)")
    options = plots.parse(parser)
    options.target_samples = options.target_samples or (8 if options.quick else 32)
    options.width, options.reference_samples, options.most_samples = (64, 256, 64) if options.quick else (256, 1024, 256)
    places = figure_places(options.quick)
    known = references(places, options.width, options.reference_samples, options.cache)
    results = {place: measure(*place, known[place], options) for place in places}
    plots.write_csv(options.output / "equal-quality.csv", [
        {"scene": scene, "light": light, "strategy": name, "seed": seed, "samples": samples, "mse": mse, "processor_s": seconds,
         "target_mse": found["target"], "reference_variance": known[scene, light].variance}
        for (scene, light), found in results.items() for name, curves in found["curves"].items()
        for seed, curve in zip(SEEDS, curves) for samples, mse, seconds in curve])
    plots.save(plots.strategy_rows([
        (f"{scene} under {light}, MSE {found['target']:.1e}", known[scene, light].radiance,
         {name: (found["pictures"][name][0], "MSE {1:.2e}\nSPP {0}".format(*found["pictures"][name][1])) for name in STRATEGIES})
        for (scene, light), found in results.items()]), options.output / "equal-quality.png")
    (options.output / "equal-quality.md").write_text(report(options, known, results))
    print(f"Report: {options.output / 'equal-quality.md'}")


if __name__ == "__main__":
    plots.run(main)

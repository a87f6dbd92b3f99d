#!/usr/bin/python3
"""The papers' convergence graphs (journal figures 11 to 13): squared error against samples and time; is its slope −1?

Writes convergence.md, .csv and .svg. About ten minutes on two cores.

    studies/convergence.py [--quick] [--samples 4096] [--width 80] [--output DIR] [--cache DIR]
"""
import argparse
import math

import matplotlib.pyplot as plt
import numpy as np

import plots
from common import markdown_rows, mean_and_error
from measure import confidence_interval, describe, error_curve, fit_slope, references, share_of_worst, student_probability
from scenes import PAPERS, STRATEGIES, figure_places, open_session

SEEDS = (1, 2, 3, 4)
# auto's numbers are stratified over blocks of 16 samples, within which its error falls faster.
SLOPE_FROM = 16
# More of the error than this in a thousandth of the pixels is fireflies.
HEAVY = 0.1
# How many standard errors a slope may be off.
ALLOWED = 2.5
# A slope that is known less well than this agrees with much.
KNOWN = 0.05


# --- measuring ------------------------------------------------------------------------------------------------------------

def measure(scene, light, known, options):
    """{strategy: {"curves": error_curve of each seed, "worst": share of the error in the worst thousandth of the pixels}}"""
    found = {}
    for name in STRATEGIES:
        plots.progress(f"{scene} under {light}: {name}")
        session = open_session(scene, light, width=options.width, strategy=name)
        curves, worst = [], []
        for seed in SEEDS:
            session.render_settings = session.render_settings.replace(seed=seed)
            curves.append(error_curve(session, known, options.counts))
            worst.append(share_of_worst(session.image(), known))
        found[name] = {"curves": curves, "worst": sum(worst) / len(worst)}
    return found


# --- slopes ---------------------------------------------------------------------------------------------------------------

def slopes(curves):
    """Least-squares slope of log MSE over log samples for each seed, from SLOPE_FROM on."""
    each = []
    for curve in curves:
        points = [(math.log(n), math.log(error)) for n, error, _ in curve if n >= SLOPE_FROM and error > 0]
        each.append(fit_slope(*zip(*points), 1.0)[0])
    return each


def verdict(curves):
    """(slope, its standard error, how many of them it is from −1)."""
    slope, error = mean_and_error(slopes(curves))
    return slope, error, (slope + 1) / error


# --- reporting ------------------------------------------------------------------------------------------------------------

def band(curves):
    """Samples, mean time, geometric mean of the error, and the 95 % interval of the mean of its logarithm."""
    columns = []
    for points in zip(*curves):
        errors = [error for _, error, _ in points]
        if min(errors) > 0:
            logs = [math.log(error) for error in errors]
            low, high = confidence_interval(logs)
            columns.append((points[0][0], sum(seconds for _, _, seconds in points) / len(points),
                            math.exp(sum(logs) / len(logs)), math.exp(low), math.exp(high)))
    return np.array(columns).T


def figure(results):
    drawing, all_axes = plt.subplots(len(results), 2, figsize=(7.2, 2.5 * len(results) + 0.3), squeeze=False, sharey="row")
    for row, ((scene, light), found) in zip(all_axes, results.items()):
        lines = []
        for name, entry in found.items():
            samples, seconds, error, low, high = band(entry["curves"])
            lines.append(error)
            for axes, along in zip(row, (samples, seconds)):
                axes.fill_between(along, low, high, color=plots.COLOURS[name], alpha=0.2, linewidth=0)
                axes.plot(along, error, color=plots.COLOURS[name], label=plots.LABELS[name])
        # A slope of −1 to compare with, below everything.
        least = min(line[-1] for line in lines)
        row[0].plot(samples, least / 3 * samples[-1] / samples, color="#999999", linestyle=":", label="slope −1")
        row[0].set(title=f"{scene} under {light}", xlabel="samples a pixel", ylabel="mean squared error")
        row[1].set(title="the same against time", xlabel="processor time, s")
        for axes in row:
            axes.set(xscale="log", yscale="log", ylim=(min(map(min, lines)) / 5, max(map(max, lines)) * 3))
        row[0].set_xscale("log", base=2)
    drawing.legend(*all_axes[0][0].get_legend_handles_labels(), loc="upper center", ncols=7)
    drawing.tight_layout(rect=(0, 0, 1, 1 - 0.25 / drawing.get_figheight()))
    return drawing


def signed(slope, error):
    return f"{slope:.3f} ± {error:.3f}".replace("-", "−")


def table(results):
    rows = []
    for (scene, light), found in results.items():
        for name, entry in found.items():
            slope, error, off = verdict(entry["curves"])
            samples, seconds, errors, *_ = band(entry["curves"])[:, -1]
            rows.append([f"{scene}, {light}", name, signed(slope, error), f"{off:+.1f}".replace("-", "−"),
                         "yes" if abs(off) <= ALLOWED else "**no**", f"{100 * entry['worst']:.1f} %", f"{errors:.3g}",
                         f"{1000 * seconds / samples:.2f}"])
    return markdown_rows(["scene, light", "strategy", "slope", "(slope + 1) / error", f"within {ALLOWED}",
                          "error in the worst 0.1 % of pixels", f"MSE at {samples:.0f}", "ms a sample of all pixels"], rows)


def orders(found):
    """The papers' five by their error, from least to most, at each sample count."""
    bands = {name: dict(zip(*band(found[name]["curves"])[[0, 2]])) for name in PAPERS}
    counts = sorted(set.intersection(*(set(values) for values in bands.values())))
    return {int(n): sorted(PAPERS, key=lambda name: bands[name][n]) for n in counts}


def reason(slope, worst):
    """Why a slope is off."""
    if worst < HEAVY:
        return (f"{100 * worst:.0f} % of its squared error lies in the worst 0.1 % of the pixels, so that fireflies tell little; "
                "chance, milder rare samples, and what is not known of the reference's own part, remain")
    return f"{100 * worst:.0f} % of its squared error lies in the worst 0.1 % of the pixels: rare samples of large weight, " + (
        "of which a run has too few at first, and its error steps up with each that it meets" if slope > -1 else
        "met early and then diluted, with the square of the samples")


def words(results):
    """Where ours differs from the papers' and why, from what was measured."""
    judged = [(f"{scene} under {light}, {name}", *verdict(entry["curves"]), entry["worst"])
              for (scene, light), found in results.items() for name, entry in found.items()]
    off = [entry for entry in judged if abs(entry[3]) > ALLOWED]
    known = [entry for entry in judged if entry[2] < KNOWN]
    by_chance = len(judged) * (1 - student_probability(ALLOWED, len(SEEDS) - 1))
    lines = [plots.prose(f"""**Slopes.** {len(judged) - len(off)} of {len(judged)} are −1 within {ALLOWED} of their
        standard errors, {len([entry for entry in known if entry not in off])} of the {len(known)} whose standard error is below
        {KNOWN}; the others tell little. Errors come from {len(SEEDS)} seeds, so that chance alone puts about {by_chance:.1f} of
        {len(judged)} outside.""", "- ")]
    for place, slope, error, _, worst in off:
        lines.append(plots.prose(f"{place}: {signed(slope, error)}; {reason(slope, worst)}.", "  - "))
    first_block = [error[0] / error[list(samples).index(SLOPE_FROM)]
                   for samples, _, error, *_ in (band(found["auto"]["curves"]) for found in results.values())]
    heaviest = max(judged, key=lambda entry: entry[4])
    lines.append(plots.prose(f"""
        **Fireflies.** The papers see visibility sampling start well, converge worse and leave more fireflies than the rest, and
        blame directions that coarse visibility takes for hidden though a lamp shines there. Every unbiased strategy of finite
        variance has the slope −1 in expectation; what differs is how late a single run shows it. Most of the error in few
        pixels is in {heaviest[0]}: {100 * heaviest[4]:.0f} % in 0.1 % of them. Our ε of 0.1, the papers' is 0.01, bounds the
        weight of a direction that is taken for hidden (`docs/architecture.md`).

        **auto**'s error falls by {' / '.join(f"{value:.1f}" for value in first_block)} times from 1 to {SLOPE_FROM} samples,
        its first block of stratified ones, where a slope of −1 has {SLOPE_FROM}; slopes are taken from there on.
        """, "- "))
    lines.append(plots.prose("""**Order.** By the papers' words uniform sampling is worst, two-step best, and visibility sampling
        alone is better at first than later. Here, of the papers' five, by the geometric mean over seeds:""", "- "))
    for (scene, light), found in results.items():
        by_count = orders(found)
        (first, at_first), *_, (last, at_last) = by_count.items()
        order = f"{' < '.join(at_last)} at {last} samples"
        if any(names != at_last for names in by_count.values()):
            order = f"{' < '.join(at_first)} at {first}, {order}"
        uniform, visibility = (band(found[name]["curves"])[2] for name in ("uniform", "visibility"))
        lines.append(plots.prose(f"""{scene} under {light}: {order}; uniform over visibility sampling's error from
            {uniform[0] / visibility[0]:.2g} to {uniform[-1] / visibility[-1]:.2g}.""", "  - "))
    return "\n".join(lines)


def report(options, known, results):
    unknown = max(known[place].variance * known[place].doubt / band(entry["curves"])[2].min()
                  for place, found in results.items() for entry in found.values())
    about = plots.prose(f"""
        Journal paper, figures 11 to 13: mean squared error of one progressive render at powers of two, up to
        {options.counts[-1]} samples a pixel of {options.width} × {options.width}, background hidden. Lines are geometric means
        over {len(SEEDS)} seeds, bands the 95 % interval of the mean of the logarithm at each count; counts of a seed are of
        one render, so that the bands of neighbours are not independent. Where few pixels have most of the error the mean of the
        logarithm is below the logarithm of the mean. The reference's own variance is taken off; what is not known of it (±
        below) is the same for all seeds and not in the bands, at most {100 * unknown:.2g} % of an error. Processor time is that
        of the passes over all threads, without majorants, sweep and joint grid. Slopes are least-squares lines through the
        logarithms from {SLOPE_FROM} samples on, one a seed; ± is the standard error over seeds, which are independent.

        {plots.header("convergence", options, f"Seeds {', '.join(map(str, SEEDS))}.", describe(known))}

        ![mean squared error against samples and time](convergence.svg)
        """)
    return "\n\n".join(["# Convergence", about, "## Where ours differs from the papers', and why", words(results), "## Slopes",
                        table(results)]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=None, help="the most, a power of two (4096)")
    parser.add_argument("--width", type=int, default=None, help="pixels along each side (80)")
    options = plots.parse(parser)
    most = options.samples or (128 if options.quick else 4096)
    options.width = options.width or (40 if options.quick else 80)
    options.counts = [2 ** k for k in range(int(math.log2(most)) + 1)]
    places = figure_places(options.quick)
    known = references(places, options.width, 2 * most, options.cache)
    results = {place: measure(*place, known[place], options) for place in places}
    plots.write_csv(options.output / "convergence.csv", [
        {"scene": scene, "light": light, "strategy": name, "seed": seed, "samples": samples, "mse": mse, "processor_s": seconds,
         "reference_variance": known[scene, light].variance}
        for (scene, light), found in results.items() for name, entry in found.items()
        for seed, curve in zip(SEEDS, entry["curves"]) for samples, mse, seconds in curve])
    plots.save(figure(results), options.output / "convergence.svg")
    (options.output / "convergence.md").write_text(report(options, known, results))
    print(f"Report: {options.output / 'convergence.md'}")


if __name__ == "__main__":
    plots.run(main)

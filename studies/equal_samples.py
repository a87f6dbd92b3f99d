#!/usr/bin/python3
"""The papers' comparison at equal samples (journal figure 10), and variance over all scenes under all lights.

Writes equal-samples.md, .csv, .png and equal-samples-all.csv. About five minutes on two cores, two of them for references
that other studies use, too.

    studies/equal_samples.py [--quick] [--output DIR] [--cache DIR]
"""
import argparse
import math

import plots
from common import geometric_mean, markdown_rows, ratio, with_error
from measure import describe, interval_reach, radiance_of, references, squared_error
from scenes import LIGHTS, PAPERS, QUICK_LIGHT, QUICK_SCENES, SCENES, STRATEGIES, figure_places, need, open_session, parts

SEEDS = (1, 2, 3)
# For variance over all scenes and lights: halves of the samples with seeds of their own, which tell how sure it is.
WIDE_SEEDS = (1, 2)
WIDE = ("environment", "two-step", "auto")

# Journal paper, figure 10, two-step and environment sampling: mean squared errors from the fewest samples to the most.
PAPER = {"Beetle": ((106.77, 10.21, 5.17), (88.62, 8.18, 4.21)), "Statue": ((149.98, 22.93, 5.75), (12.02, 1.56, 0.4)),
         "Backpack": ((52.35, 14.54, 3.92), (38.35, 10.65, 2.88))}


# --- measuring ------------------------------------------------------------------------------------------------------------

def measure(scene, light, known, options):
    """{strategy: [{samples: squared error} of each seed]} and {(strategy, samples): image of the first seed}."""
    errors, images = {}, {}
    for name in STRATEGIES:
        plots.progress(f"{scene} under {light}: {name}")
        session = open_session(scene, light, width=options.width, strategy=name)
        errors[name] = []
        for seed in SEEDS:
            session.render_settings = session.render_settings.replace(seed=seed)
            found = {}
            for samples in options.counts:
                image = radiance_of(session.render(samples=samples))
                found[samples] = squared_error(image, known)
                images.setdefault((name, samples), image)
            errors[name].append(found)
    return errors, images


def variances(scenes, lights, options):
    """{(scene, light): {strategy: the film's own relative variance with each seed}}: no reference is needed."""
    found = {}
    for scene in scenes:
        plots.progress(f"{scene}: variance under {len(lights)} lights")
        session = open_session(scene, lights[0], width=options.wide_width)
        for light in lights:
            session.environment = parts(scene, light)[3]
            found[scene, light] = {}
            for name in WIDE:
                found[scene, light][name] = []
                for seed in WIDE_SEEDS:
                    session.render_settings = session.render_settings.replace(strategy=name, seed=seed)
                    session.render(samples=options.wide_samples)
                    found[scene, light][name].append(session.noise ** 2)
    return found


# --- reporting ------------------------------------------------------------------------------------------------------------

def interval(errors, name, samples):
    values = [found[samples] for found in errors[name]]
    return sum(values) / len(values), interval_reach(values)


def gain(errors, name, samples):
    return ratio(interval(errors, "environment", samples), interval(errors, name, samples))


def table(errors, counts):
    rows = []
    for name in STRATEGIES:
        rows.append([name, *[with_error(*interval(errors, name, n)) for n in counts],
                     *["1" if name == "environment" else with_error(*gain(errors, name, n)) for n in counts]])
    return markdown_rows(["strategy", *[f"MSE at {n}" for n in counts], *[f"gain at {n}" for n in counts]], rows)


def gain_of(entry, name):
    return sum(entry["environment"]) / sum(entry[name])


def gain_error(wide, name):
    """Relative standard error of a gain, root mean square over places: from what the seeds' logarithms differ by."""
    differences = [math.log(entry["environment"][0] / entry[name][0]) - math.log(entry["environment"][1] / entry[name][1])
                   for entry in wide.values()]
    return math.sqrt(sum(difference ** 2 for difference in differences) / len(differences)) / 2


def wide_table(wide):
    lights = list(dict.fromkeys(light for _, light in wide))

    def cell(entries):
        return ", ".join(f"{geometric_mean([gain_of(entry, name) for entry in entries]):.2f}" for name in ("two-step", "auto"))

    rows = [[scene, *[cell([wide[scene, light]]) for light in lights], cell([wide[scene, light] for light in lights])]
            for scene in dict.fromkeys(scene for scene, _ in wide)]
    rows.append(["geometric mean", *[cell([entry for (_, of), entry in wide.items() if of == light]) for light in lights],
                 cell(list(wide.values()))])
    return markdown_rows(["scene: two-step, auto", *lights, "geometric mean"], rows)


def words(results, wide, options):
    """Where ours differs from the papers' and why, from what was measured."""
    last = options.counts[-1]
    lines = []
    for (scene, light), (errors, _) in results.items():
        means = {n: {name: interval(errors, name, n)[0] for name in PAPERS} for n in options.counts}
        best = [f"{min(found, key=found.get)} at {n}" for n, found in means.items()]
        lines.append(plots.prose(f"""**{scene} under {light}**: least error of the papers' five: {', '.join(best)}. At
            {last} samples {' < '.join(sorted(means[last], key=means[last].get))}.""", "- "))
    papers = "; ".join(f"{plots.slashed([a / b for a, b in zip(*columns)])} on the {name}" for name, columns in PAPER.items())
    two_step = [gain(errors, "two-step", last)[0] for errors, _ in results.values()]
    lines.append(plots.prose(f"""
        **Two-step against environment sampling.** The paper's figure has {papers}, from the fewest samples to the most. Ours at
        {last} samples: {plots.slashed(two_step)}. The scenes are not the same, and what there is to gain is, for hard shadows,
        one over the share of the light that arrives. In the paper two-step is best at every count; here, where the lines above
        say so.
        """, "- "))
    far = [name for name in ("uniform", "visibility", "combined")
           if any(gain(errors, name, last)[0] < 0.1 for errors, _ in results.values())]
    if far:
        lines.append(plots.prose(f"""
            **More than ten times behind environment sampling** in a scene here: {', '.join(far)}; in the paper's figure nothing
            is. Photographed lights have lamps of a few texels, which directions that do not know them meet rarely, and then
            with a large weight; `equal-time.md` has the second moments of these lights.
            """, "- "))
    ratios = [gain_of(entry, "two-step") for entry in wide.values()]
    sure = 2 * gain_error(wide, "two-step")
    worse = [f"{scene} under {light}" for (scene, light), entry in wide.items() if gain_of(entry, "two-step") < 1 - sure]
    lines.append(plots.prose(f"""
        **Over all scenes and lights** environment sampling has {min(ratios):.2f} to {max(ratios):.2f} times two-step's
        variance, below 1 by more than two standard errors in {len(worse)} of {len(wide)}{': ' * bool(worse)}{', '.join(worse)}.
        Where nearly all light arrives, visibility has nothing to tell.

        **auto** is ours. A sample of it is three collisions and shadow rays: at equal samples it does more work, at equal time
        (`equal-time.md`) it does not.
        """, "- "))
    return "\n".join(lines)


def report(options, known, results, wide):
    about = plots.prose(f"""
        Journal paper, figure 10: every strategy at {', '.join(map(str, options.counts))} samples a pixel. {options.width} ×
        {options.width} pixels, background hidden; ± is half of the 95 % interval over {len(SEEDS)} seeds, and the reference's
        own variance is taken off. **gain**: error of environment sampling over the strategy's, ± from both intervals as if they
        were independent. Counts of one seed are of one progressive render, so that neighbouring columns are not independent.

        {plots.header("equal_samples", options, f"Seeds {', '.join(map(str, SEEDS))}.", describe(known))}

        ![windows of every image](equal-samples.png)

        Left the reference with the part that is magnified, below it the light. Errors are those of the images shown, the first
        seed's.
        """)
    text = ["# Equal samples", about, "## Where ours differs from the paper's, and why", words(results, wide, options)]
    text += [f"## {scene} under {light}\n\n{table(errors, options.counts)}" for (scene, light), (errors, _) in results.items()]
    text += ["## All scenes, all lights", plots.prose(f"""
        Environment sampling's variance over the strategy's, at {options.wide_samples} samples a pixel of
        {options.wide_width} × {options.wide_width}: the film's own estimate (`Session.noise`, squared), which for auto comes
        from its blocks of 16 stratified samples. Mean of seeds {' and '.join(map(str, WIDE_SEEDS))}; the standard error of a
        number, by what the two differ by, is {100 * gain_error(wide, 'two-step'):.2g} % for two-step and
        {100 * gain_error(wide, 'auto'):.2g} % for auto, root mean square over scenes and lights. All numbers:
        equal-samples-all.csv.
        """), wide_table(wide)]
    return "\n\n".join(text) + "\n"


# --- the picture ----------------------------------------------------------------------------------------------------------

SIDE, INSET, GAP, TITLE, CAPTION, LEFT = 32, 96, 6, 18, 14, 256


def picture(known, results, counts):
    height = TITLE + (INSET + CAPTION + GAP) * len(counts) + GAP
    canvas = plots.Canvas(GAP + LEFT + 34 + (INSET + GAP) * len(STRATEGIES) + GAP, height * len(results))
    for index, ((scene, light), (_, images)) in enumerate(results.items()):
        top = index * height + TITLE
        reference = known[scene, light].radiance
        corner = plots.telling_window(reference, SIDE)
        canvas.text(f"{scene} under {light}", GAP, top - 16, fontsize=9)
        axes = canvas.image(plots.display([reference])[0], GAP, top, (LEFT, LEFT))
        plots.mark_window(axes, corner, SIDE, LEFT / reference.shape[0])
        canvas.image(plots.display([plots.latlong(parts(scene, light)[3])])[0], GAP, top + LEFT + GAP, (LEFT * 2 // 3, LEFT // 3))
        for column, name in enumerate(STRATEGIES):
            left = GAP + LEFT + 34 + column * (INSET + GAP)
            canvas.text(plots.LABELS[name], left, top - 14, fontsize=8, color=plots.COLOURS[name], weight="bold")
            shown = plots.display([images[name, n] for n in counts], reference)
            for row, (n, pixels) in enumerate(zip(counts, shown)):
                place = top + row * (INSET + CAPTION + GAP)
                canvas.inset(pixels, corner, SIDE, left, place, INSET, plots.COLOURS[name])
                canvas.text(f"MSE {squared_error(images[name, n], known[scene, light]):.2e}", left, place + INSET + 3)
                if column == 0:
                    canvas.text(f"{n}\nSPP", left - 28, place + 4)
    return canvas.figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options = plots.parse(parser)
    options.width, options.reference_samples = (64, 256) if options.quick else (256, 1024)
    options.counts = (2, 8, 32) if options.quick else (8, 32, 128)
    options.wide_width, options.wide_samples = (48, 32) if options.quick else (128, 48)
    all_scenes, all_lights = (QUICK_SCENES, [QUICK_LIGHT]) if options.quick else (SCENES, LIGHTS)
    need(all_scenes, all_lights)
    places = figure_places(options.quick)
    known = references(places, options.width, options.reference_samples, options.cache)
    results = {place: measure(*place, known[place], options) for place in places}
    wide = variances(all_scenes, all_lights, options)
    plots.write_csv(options.output / "equal-samples.csv", [
        {"scene": scene, "light": light, "strategy": name, "seed": seed, "samples": samples, "mse": mse,
         "reference_variance": known[scene, light].variance}
        for (scene, light), (errors, _) in results.items() for name in STRATEGIES
        for seed, found in zip(SEEDS, errors[name]) for samples, mse in found.items()])
    plots.write_csv(options.output / "equal-samples-all.csv", [
        {"scene": scene, "light": light, "strategy": name, "seed": seed, "samples": options.wide_samples,
         "relative_variance": value}
        for (scene, light), entry in wide.items() for name, values in entry.items() for seed, value in zip(WIDE_SEEDS, values)])
    plots.save(picture(known, results, options.counts), options.output / "equal-samples.png")
    (options.output / "equal-samples.md").write_text(report(options, known, results, wide))
    print(f"Report: {options.output / 'equal-samples.md'}")


if __name__ == "__main__":
    plots.run(main)

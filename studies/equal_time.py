#!/usr/bin/python3
"""The papers' comparison at equal time (journal figure 9): ten seconds for every strategy, after the sweep.

Writes equal-time.md, .csv and .png. About five minutes on two cores, two of them for references that other studies use, too.

    studies/equal_time.py [--quick] [--seconds 10] [--output DIR] [--cache DIR]
"""
import argparse
import math
import time
from statistics import mean

import plots
from common import geometric_mean, markdown_rows, ratio, with_error
from measure import describe, interval_reach, radiance_of, references, relative_squared_error, squared_error, weight_moments
from scenes import STRATEGIES, figure_places, open_session, parts

# An image is the mean of so many renders with seeds of their own, which tell how sure its error is.
RENDERS = 4
SLICE_SECONDS = 0.25

# Journal paper, figure 9: samples a pixel, mean squared error.
PAPER = {"uniform": (112, 10.6e-3), "environment": (130, 4.9e-3), "visibility": (115, 9.6e-3), "combined": (101, 7.2e-3),
         "two-step": (99, 3.0e-3)}


# --- measuring ------------------------------------------------------------------------------------------------------------

class Contender:
    """A strategy with its processor time, spent in slices."""

    def __init__(self, scene, light, strategy, width, seconds):
        self.session = open_session(scene, light, width=width, strategy=strategy)
        self.slice = SLICE_SECONDS * self.session.threads
        self.budget = seconds * self.session.threads / RENDERS
        self.renders, self.spent = [], []
        self.session.prepare()
        begin = time.process_time()
        self.session.render(samples=1)
        self.cost = time.process_time() - begin
        self.begin_render()

    def begin_render(self):
        self.session.render_settings = self.session.render_settings.replace(seed=1 + len(self.renders))
        self.used = 0.0

    def take_turn(self):
        """Renders for a slice; False when all time is spent."""
        samples = min(max(1, round(self.slice / self.cost)), int((self.budget - self.used) / self.cost))
        if samples < 1 and self.used > 0:
            self.renders.append((self.session.samples, radiance_of(self.session.image())))
            self.spent.append(self.used)
            if len(self.renders) == RENDERS:
                return False
            self.begin_render()
            return True
        begin = time.process_time()
        self.session.render(samples=self.session.samples + max(1, samples))
        self.used += time.process_time() - begin
        self.cost = self.used / self.session.samples
        return True

    def result(self, known):
        """The mean of the renders and its error: that of each of them, times its share of the samples, says what that is.

        The mean of these is known twice as well as the squared error of the one image that is shown, and has an interval.
        """
        total = sum(samples for samples, _ in self.renders)
        image = sum(samples / total * radiance for samples, radiance in self.renders)
        scaled = [squared_error(radiance, known) * samples / total for samples, radiance in self.renders]
        relative = [relative_squared_error(radiance, known) * samples / total for samples, radiance in self.renders]
        return {"image": image, "samples": total, "seconds": sum(self.spent) / self.session.threads,
                "mse": mean(scaled), "reach": interval_reach(scaled), "relmse": mean(relative),
                "image_mse": squared_error(image, known)}


def measure(scene, light, known, options):
    """{strategy: result} of ten seconds each."""
    contenders = {name: Contender(scene, light, name, options.width, options.seconds) for name in STRATEGIES}
    plots.progress(f"{scene} under {light}: {options.seconds:g} s for each of {len(contenders)} strategies")
    at_work = list(contenders.values())
    while at_work:
        at_work = [contender for contender in at_work if contender.take_turn()]
    return {name: contender.result(known) for name, contender in contenders.items()}


# --- reporting ------------------------------------------------------------------------------------------------------------

def gain(entries, name):
    """Error of environment sampling over the strategy's, with what its interval allows."""
    return ratio((entries["environment"]["mse"], entries["environment"]["reach"]), (entries[name]["mse"], entries[name]["reach"]))


def table(entries):
    rows = []
    for name, entry in entries.items():
        paper = PAPER.get(name)
        rows.append([name, str(entry["samples"]), with_error(entry["mse"], entry["reach"]), f"{entry['relmse']:.3g}",
                     "1" if name == "environment" else with_error(*gain(entries, name)),
                     f"{PAPER['environment'][1] / paper[1]:.2f}" if paper else "–",
                     f"{entry['samples'] / entries['environment']['samples']:.2f}",
                     f"{paper[0] / PAPER['environment'][0]:.2f}" if paper else "–"])
    return markdown_rows(["strategy", "SPP", "MSE", "relMSE", "gain", "gain, paper", "SPP / environment's", "same, paper"], rows)


def order(errors):
    return " < ".join(sorted(errors, key=errors.get))


def neighbours(entries):
    ordered = sorted(PAPER, key=lambda name: entries[name]["mse"])
    return zip(ordered, ordered[1:])


def told_apart(a, b):
    return abs(a["mse"] - b["mse"]) > math.hypot(a["reach"], b["reach"])


def words(results, moments):
    """Where ours differs from the papers' and why, from what was measured."""
    paper_order = order({name: mse for name, (_, mse) in PAPER.items()})
    orders = {f"{scene} under {light}": order({name: entries[name]["mse"] for name in PAPER})
              for (scene, light), entries in results.items()}
    same = [place for place, found in orders.items() if found == paper_order]
    gains = {name: [gain(entries, name)[0] for entries in results.values()] for name in ("two-step", "auto")}
    close = [f"{place[0]} under {place[1]}, {first} and {second}" for place, entries in results.items()
             for first, second in neighbours(entries) if not told_apart(entries[first], entries[second])]
    samples = {name: [entries[name]["samples"] / entries["environment"]["samples"] for entries in results.values()]
               for name in ("uniform", "two-step")}
    of_lights = "; ".join(f"{light}: {uniform:.0f} for uniform directions, {combined:.1f} for the averages of combined sampling"
                          for light, (uniform, combined) in moments.items())
    lines = [plots.prose(f"**Order of errors.** In the paper {paper_order}. The same: {', '.join(same) or 'nowhere'}.", "- ")]
    lines += [plots.prose(f"{place}: {found}.", "  - ") for place, found in orders.items() if found != paper_order]
    if close:
        lines.append(plots.prose(f"Nearer than their intervals: {'; '.join(close)}.", "  - "))
    lines.append(plots.prose(f"""
        **Two-step against environment sampling**, which has {plots.slashed(gains["two-step"])} times its error in the same time,
        {geometric_mean(gains["two-step"]):.2f} in the geometric mean; the paper's figure shows 4.9 / 3.0 = 1.63 for its one
        scene. What there is to gain is decided by how much of the light is hidden from where it would be seen: the number
        belongs to the scene.

        **Uniform, visibility and combined sampling.** The second moment of light over density, relative to the squared mean,
        were nothing in shadow, which is 1 for the light as it is: {of_lights}. Photographed lamps and suns are a few texels,
        and this is what visibility has to make up, of which uniform sampling knows nothing. The papers do not tell how bright
        their lights are.

        **Samples in the same time.** Uniform sampling makes {plots.slashed(samples["uniform"])} times environment sampling's,
        two-step {plots.slashed(samples["two-step"])} times (paper: 0.86 and 0.76). On the papers' GPU incoherent rays cost, and
        a joint density built for every collision; here paths go through streams that are packed again every round, and one of
        the eight cells is drawn rather than their product built (`docs/architecture.md`).

        **auto** is ours: two-step's density, three collisions a camera ray, stratified numbers;
        two-step has {plots.slashed([a / b for a, b in zip(gains["auto"], gains["two-step"])])} times its error in the same time.
        A sample of it is more work.

        **Units.** Errors are of linear radiance in each light's own scale; only ratios can be laid beside the papers'.
        """, "- "))
    return "\n".join(lines)


def report(options, known, results, moments):
    about = plots.prose(f"""
        Journal paper, figure 9: every strategy has {options.seconds:g} seconds of rendering on all cores; what comes before
        (majorants, sweep, joint grid) is not counted. {options.width} × {options.width} pixels, background hidden. Other work
        may run on the machine, so strategies take turns in slices of a quarter of a second, and the clock is the processor time
        of all threads, {options.seconds:g} s × threads. An image is the mean of {RENDERS} renders of different seeds that share
        the time. MSE in the tables is what each of the four says of their mean's, its own error times its share of the samples:
        their average, ± half of the 95 % interval. That of the one image is below it in the picture. The reference's own
        variance is taken off. **gain**: error of environment sampling over the strategy's, ± from both intervals as if they
        were independent.

        {plots.header("equal_time", options, f"Seeds 1 to {RENDERS}.", describe(known))}

        ![the reference, and a part of every image](equal-time.png)

        Left the reference, with the part that is magnified: the one with the most light and shadow.
        """)
    text = ["# Equal time", about, "## Where ours differs from the paper's, and why", words(results, moments)]
    text += [f"## {scene} under {light}\n\n{table(entries)}" for (scene, light), entries in results.items()]
    return "\n\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=None, help="for each strategy (10)")
    options = plots.parse(parser)
    options.seconds = options.seconds or (0.2 if options.quick else 10)
    options.width, options.reference_samples = (64, 256) if options.quick else (256, 1024)
    places = figure_places(options.quick)
    known = references(places, options.width, options.reference_samples, options.cache)
    results = {place: measure(*place, known[place], options) for place in places}
    moments = {light: weight_moments(parts(scene, light)[3]) for scene, light in places}
    plots.write_csv(options.output / "equal-time.csv", [
        {"scene": scene, "light": light, "strategy": name, "reference_variance": known[scene, light].variance,
         **{key: entry[key] for key in entry if key != "image"}}
        for (scene, light), entries in results.items() for name, entry in entries.items()])
    plots.save(plots.strategy_rows([
        (f"{scene} under {light}", known[scene, light].radiance,
         {name: (entry["image"], f"MSE {entry['image_mse']:.2e}\nSPP {entry['samples']}") for name, entry in entries.items()})
        for (scene, light), entries in results.items()]), options.output / "equal-time.png")
    (options.output / "equal-time.md").write_text(report(options, known, results, moments))
    print(f"Report: {options.output / 'equal-time.md'}")


if __name__ == "__main__":
    plots.run(main)

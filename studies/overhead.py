#!/usr/bin/python3
"""What joint sampling costs in memory, time a path and preparation (both papers' "Timings and Parameters"):
docs/results/overhead.md.

Processor time of one thread. Strategies take turns in short slices, so that other work on the machine reaches all of them
alike. About three minutes.

    studies/overhead.py [--quick]
"""
import argparse
import time

import numpy as np

import plots
import scenes
from ablation import DEFAULT, FILTERS, Setting
from common import divide, markdown_rows, mean_and_error, with_error
from scenes import lumisweep

LIGHT = "courtyard"
PAPERS_OVERHEAD = 0.10


# --- time a path ----------------------------------------------------------------------------------------------------------

def counts(stats):
    return np.array([stats["paths"], stats["shadow_rays"]["traced"], stats["steps"]["shadow"]])


class Turns:
    """Sessions of one thread, rendering in turns of about a slice each."""

    def __init__(self, sessions, slice_s):
        self.sessions, self.slice_s = sessions, slice_s
        self.passes = {}
        for name, session in sessions.items():
            session.prepare()
            session.render(samples=1)  # what is only done once
            self.passes[name] = max(1, round(slice_s / max(self.take(name, 1)[0], 1e-6)))
        self.order = list(sessions)

    def take(self, name, passes):
        """Processor seconds, paths, collisions with a shadow ray, and steps of shadow rays, of that many passes."""
        session = self.sessions[name]
        before, begin = counts(session.stats), time.process_time()
        session.render(samples=session.samples + passes)
        return np.array([time.process_time() - begin, *(counts(session.stats) - before)])

    def rounds(self, count):
        """{name: [rounds, (seconds, paths, shadow rays, their steps)]}"""
        taken = {name: [] for name in self.order}
        for index in range(count):
            # Every one follows every other about as often.
            for name in np.random.default_rng(index).permutation(self.order):
                taken[name].append(self.take(name, self.passes[name]))
        return {name: np.array(rows) for name, rows in taken.items()}


def time_a_path(rows):
    return rows[:, 0] / rows[:, 1]


def over(taken, name, base):
    """Time a path of one over that of another, round by round: mean and standard error."""
    return mean_and_error(list(time_a_path(taken[name]) / time_a_path(taken[base])))


def steps_over(taken, name, base):
    """Steps of shadow rays, a path."""
    return divide(*(taken[n][:, 3].sum() / taken[n][:, 1].sum() for n in (name, base)))


def nanoseconds_a_collision(taken, name, base):
    """What one takes more than another, by the collisions at which directions are chosen: mean and standard error."""
    a, b = taken[name], taken[base]
    return mean_and_error(list(1e9 * (time_a_path(a) - time_a_path(b)) * a[:, 1] / a[:, 2]))


def as_they_are(scene, light, width, slice_s, rounds):
    sessions = {strategy: scenes.open_session(scene, light, width=width, strategy=strategy, threads=1)
                for strategy in scenes.PAPERS}
    return Turns(sessions, slice_s).rounds(rounds)


def alike(scene, light, width, slice_s, rounds):
    """Light and visibility the same from everywhere: all strategies have the uniform density, and only choosing differs.

    The environment has the real one's resolution and the grids have their own, so as much memory is read.
    """
    volume, transfer_function, camera, real = scenes.parts(scene, light)
    environment = lumisweep.Environment.from_octahedral(np.ones((real.resolution, real.resolution, 3), np.float32))
    shape = (DEFAULT.directions, DEFAULT.directions, *lumisweep.cell_centres(volume, cell=DEFAULT.cell).shape[:3])
    everywhere = lumisweep.VisibilityGrid(np.full(shape, 255, np.uint8), volume, cell=DEFAULT.cell)
    sessions = {}
    for strategy in scenes.PAPERS:
        session = lumisweep.Session(volume, transfer_function, environment, camera=camera,
                                    image_settings=lumisweep.ImageSettings(width=width, height=width, show_environment=False),
                                    render_settings=lumisweep.RenderSettings(strategy=strategy), threads=1)
        if strategy not in ("uniform", "environment"):
            session.prepare()
            session.visibility = everywhere
        sessions[strategy] = session
    return Turns(sessions, slice_s).rounds(rounds)


def filters(scene, light, width, slice_s, rounds):
    sessions = {kind: scenes.open_session(scene, light, width=width, threads=1, visibility=Setting(filter=kind).visibility())
                for kind in FILTERS}
    return Turns(sessions, slice_s).rounds(rounds)


# --- memory and preparation -----------------------------------------------------------------------------------------------

def preparation(scene, light, width, repeats):
    """Seconds of each stage and of a pass, the least of several; bytes by what holds them; voxels; bytes a voxel."""
    runs = []
    for _ in range(repeats):
        session = scenes.open_session(scene, light, width=width, threads=1)
        session.prepare()
        stages = {stage: session.stats["seconds"][stage] for stage in ("majorants", "classify", "sweep", "joint")}
        session.render(samples=1)
        begin = time.process_time()
        session.render(samples=4)
        runs.append({**stages, "pass": (time.process_time() - begin) / 3})
    voxels, itemsize = int(np.prod(session.volume.shape)), session.volume.dtype.itemsize
    return {key: min(run[key] for run in runs) for key in runs[0]}, session.stats["memory_bytes"], voxels, itemsize


def memory_table(prepared):
    rows, kept = [], ("volume", "visibility", "joint", "environment", "majorants")
    for scene, (_, memory, voxels, itemsize) in prepared.items():
        rows.append([scene, f"{voxels / 1e6:.2f}", f"{8 * itemsize}", *[f"{memory[what] / 1e6:.3g}" for what in kept],
                     *[f"{memory[what] / voxels:.2f}" for what in ("visibility", "joint")],
                     f"{memory['visibility'] / (voxels * itemsize):.2f}"])
    return markdown_rows(["scene", "M voxels", "bits", "volume, MB", "V, MB", "joint grid, MB", "light, MB", "majorants, MB",
                          "V, bytes a voxel", "joint grid, bytes a voxel", "V / volume"], rows)


def preparation_table(prepared, width):
    stages = ("majorants", "classify", "sweep", "joint")
    rows = []
    for scene, (seconds, *_) in prepared.items():
        rows.append([scene, f"{1000 * seconds['pass']:.3g}", *[f"{1000 * seconds[stage]:.3g}" for stage in stages],
                     f"{sum(seconds[stage] for stage in stages[1:]) / seconds['pass']:.2f}"])
    return markdown_rows(["scene", f"pass of {width}², ms", *[f"{stage}, ms" for stage in stages],
                          "classify, sweep and joint, passes"], rows)


# --- report ---------------------------------------------------------------------------------------------------------------

def strategy_table(real, same):
    rows = []
    for scene in real:
        rows.append([scene, f"{1e9 * time_a_path(real[scene]['uniform']).mean():.0f}",
                     *[with_error(*over(real[scene], strategy, "uniform")) for strategy in scenes.PAPERS[1:]],
                     f"{steps_over(real[scene], 'two-step', 'uniform'):.2f}",
                     *[with_error(*over(same[scene], strategy, "uniform")) for strategy in scenes.PAPERS[1:]],
                     with_error(*nanoseconds_a_collision(same[scene], "two-step", "uniform"))])
    head = [f"{strategy}{kind}" for kind in ("", ", rays alike") for strategy in scenes.PAPERS[1:]]
    return markdown_rows(["scene", "uniform, ns a path", *head[:4], "two-step's steps of shadow rays", *head[4:],
                          "two-step, rays alike, ns more a collision"], rows)


def mean_over(of_scene, name, base):
    each = [over(taken, name, base) for taken in of_scene.values()]
    return sum(value for value, _ in each) / len(each), np.sqrt(sum(error ** 2 for _, error in each)) / len(each)


def percent(value, error):
    return f"{100 * (value - 1):+.1f} ± {100 * error:.1f} %"


def findings(prepared, real, same, filtered):
    ratio, error = mean_over(real, "two-step", "uniform")
    alone, alone_error = mean_over(same, "two-step", "uniform")
    apart = max(abs(steps_over(taken, "two-step", "uniform") - 1) for taken in same.values())
    bytes_a_voxel = [memory["visibility"] / voxels for _, memory, voxels, _ in prepared.values()]
    joint = [memory["joint"] / voxels for _, memory, voxels, _ in prepared.values()]
    passes = [sum(seconds[stage] for stage in ("classify", "sweep", "joint")) / seconds["pass"]
              for seconds, *_ in prepared.values()]
    by_filter = {kind: mean_over(filtered, kind, "none") for kind in FILTERS[1:]}
    affected = any(abs(value - 1) > max(0.01, 2 * e) for value, e in by_filter.values())
    memory_verdict = (
        "so the papers' “equal to the original data volume” holds for 8 bits a voxel, and it is half of the volume for 16"
        if max(bytes_a_voxel) < 1.2 else
        "more than the papers' “equal to the original data volume”, since cells at the sides are cut off")
    beyond = alone - 1 - PAPERS_OVERHEAD
    sampling_verdict = (
        "about the papers' 10 %" if abs(beyond) < 2 * alone_error else "within the papers' 10 %" if beyond < 0 else
        "more than the papers' 10 %: theirs is a share of paths that march from voxel to voxel, ours of paths that jump over "
        "empty space and look up little")
    each = {scene: nanoseconds_a_collision(taken, "two-step", "uniform")[0] for scene, taken in same.items()}
    least, most = min(each, key=each.get), max(each, key=each.get)
    grid_mb = {scene: memory["joint"] / 1e6 for scene, (_, memory, *_) in prepared.items()}
    return plots.prose(f"""**Memory of V**: {extent(bytes_a_voxel, 2)} bytes a voxel (64 directions of 1 byte for 4³ voxels are
        1), {memory_verdict}. But sampling descends the product with the light, which the papers build from eight cells at each
        scatter event and we keep: another {extent(joint, 1)} bytes a voxel (85 numbers of 4 bytes a cell).

        **Time a path**: two-step {percent(ratio, error)} against uniform, mean over scenes; the papers: “only around 10 %”.
        Ours is {'less' if ratio < 1 + PAPERS_OVERHEAD else 'more'}, but rays towards the light meet other things than rays in all
        directions, so that is not sampling's alone.

        **Sampling alone**, with rays alike (steps differ by {100 * apart:.1f} % at most): two-step {percent(alone, alone_error)},
        environment {percent(*mean_over(same, 'environment', 'uniform'))}, visibility
        {percent(*mean_over(same, 'visibility', 'uniform'))}. Two-step is {sampling_verdict}. It takes {each[least]:.0f} ns a
        collision ({least}, with a joint grid of {grid_mb[least]:.2g} MB) to {each[most]:.0f} ns ({most}, {grid_mb[most]:.2g} MB).

        **The filter and time a path**: half angle {percent(*by_filter['half-angle'])}, full angle
        {percent(*by_filter['full-angle'])} against none. The papers say that it does not affect render time:
        {'it does here, as' if affected else 'nor does it here, though'} other directions are drawn.

        **Preparation** (classify, sweep, joint grid) takes as long as {extent(passes, 1)} passes of one sample a pixel.""", "- ")


def extent(values, digits):
    low, high = (f"{value:.{digits}f}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def plot(real, same, path):
    figure, axes = plots.plt.subplots(figsize=(6.5, 2.6), constrained_layout=True)
    places = np.arange(len(real))
    for index, strategy in enumerate(scenes.PAPERS[1:]):
        for taken, offset, alpha in ((real, 0, 1.0), (same, 0.1, 0.4)):
            values = [over(taken[scene], strategy, "uniform") for scene in real]
            axes.bar(places + 0.2 * (index - 1.5) + offset - 0.05, [100 * (value - 1) for value, _ in values], 0.1,
                     yerr=[200 * error for _, error in values], color=plots.COLOURS[strategy], alpha=alpha,
                     error_kw={"linewidth": 0.7}, label=strategy if offset == 0 else None)
    axes.axhline(100 * PAPERS_OVERHEAD, color="#888888", linestyle=":", linewidth=1)
    axes.set_xticks(places, list(real))
    axes.set_ylabel("time a path over uniform's, %")
    axes.legend(ncol=4)
    plots.save(figure, path)


def main():
    options = plots.parse(argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter))
    quick = options.quick
    scene_names, light = (scenes.QUICK_SCENES, scenes.QUICK_LIGHT) if quick else (scenes.SCENES, LIGHT)
    width, slice_s, rounds, repeats = (64, 0.02, 4, 1) if quick else (256, 0.2, 8, 3)
    scenes.need(scene_names, [light])
    prepared, real, same, filtered = {}, {}, {}, {}
    for scene in scene_names:
        plots.progress(f"{scene} under {light}")
        prepared[scene] = preparation(scene, light, width, repeats)
        real[scene] = as_they_are(scene, light, width, slice_s, rounds)
        same[scene] = alike(scene, light, width, slice_s, rounds)
        filtered[scene] = filters(scene, light, width, slice_s, rounds)

    plot(real, same, options.output / "overhead.svg")
    plots.write_csv(options.output / "overhead.csv", [
        {"scene": scene, "what": what, "setting": name, "round": index, "seconds": row[0], "paths": int(row[1]),
         "shadow_rays": int(row[2]), "shadow_steps": int(row[3])}
        for what, of_scene in (("as they are", real), ("rays alike", same), ("filters", filtered))
        for scene, taken in of_scene.items() for name, rows in taken.items() for index, row in enumerate(rows)])
    filter_rows = [[scene, *[with_error(*over(taken, kind, "none"), 4) for kind in FILTERS[1:]]]
                   for scene, taken in filtered.items()]
    text = ["# What joint sampling costs", plots.prose(f"""
        The papers' statements on memory and overhead, on public data under {light}: cells of {DEFAULT.cell}³ voxels,
        {DEFAULT.directions}² directions, {width} × {width} pixels, one collision a path for all strategies. Times are processor
        time of one thread; strategies take turns in slices of {slice_s:g} s, {rounds} rounds, and ± is the standard error over
        rounds of the ratio within one."""), plots.header("overhead", options, "Seed 0; times need no reference."),
        findings(prepared, real, same, filtered), "![Time a path over uniform's](overhead.svg)",
        "Pale: rays alike. Dotted: the papers' 10 %. Error bars are two standard errors.", "## Time a path", plots.prose("""
        Ratios to uniform; paths that meet nothing, and need no direction, are among them. *Rays alike*: the light and V are the
        same from everywhere, in maps and grids of the usual size. Then every strategy has the uniform density and rays meet the
        same, and what remains is choosing a direction; descents go everywhere then in place of mostly to the light, so that in
        earnest it may be less."""), strategy_table(real, same), "## The filter",
        "Time a path of two-step over that without a filter.",
        markdown_rows(["scene", "half angle", "full angle"], filter_rows), "## Memory", memory_table(prepared), "## Preparation",
        plots.prose(f"""One thread, the least of {repeats}. A change of the light repeats the joint grid alone, one of the camera
        nothing; majorants are needed by all strategies."""), preparation_table(prepared, width)]
    (options.output / "overhead.md").write_text("\n\n".join(text) + "\n")
    print(f"Report: {options.output / 'overhead.md'}")
    return 0


if __name__ == "__main__":
    plots.run(main)

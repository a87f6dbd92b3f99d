"""The report of studies/sweeps.py: tables beside the papers', fractions of the machine's limits, the targets' verdicts."""
import sweeps_table_1
import sweeps_table_2
from common import markdown_rows
from sweeps_numbers import NAMES, brute_force_seconds, milliseconds, number, prepare_key, seconds, squared, sweep_key


def machine(results):
    return results.context["instruction_set"]


def ceilings(results):
    def rate(counter, isa, *name):
        return results.rate(counter, "machine", isa, *name)

    isas = [key[1] for key in results.runs if key[0] == "machine" and key[2] == "fma"]
    rows = []
    for isa in isas:
        bandwidths = [f"{rate('bytes_per_second', isa, 'read', place, 'aligned') / 1e9:.0f} / "
                      f"{rate('bytes_per_second', isa, 'read', place, 'unaligned') / 1e9:.0f}" for place in ("L1", "L2", "16MB")]
        rows.append([isa, f"{rate('flops_per_second', isa, 'fma') / 1e9:.0f}", f"{rate('quads_per_second', isa, 'dot') / 1e9:.1f}",
                     *bandwidths, f"{rate('bytes_per_second', isa, 'read', 'DRAM', 'aligned') / 1e9:.1f}",
                     f"{rate('bytes_per_second', isa, 'stream', 'DRAM') / 1e9:.1f}",
                     f"{rate('bytes_per_second', isa, 'read', 'DRAM', 'threads:2') / 1e9:.1f}"])
    return markdown_rows(["one core", "FMA, GFLOP/s", "dot products, G quads/s", "L1 read, GB/s", "L2 read", "16 MB read", "DRAM read",
                          "streaming store", "DRAM read, two threads"], rows)


def limits(results):
    """Voxel steps a second that one core could do at most: by dot products, and by 64-byte loads of 16 quads each."""
    isa = machine(results)
    dot = results.rate("quads_per_second", "machine", isa, "dot")
    loads = results.rate("bytes_per_second", "machine", isa, "read", "L1", "unaligned") / 64 * 16
    return dot, loads


def speed_up(results, one, two):
    """Of two threads over one: by wall-clock time, and by twice the processor time of one over that of both together."""
    return (results.seconds(*one, clock="real_time") / results.seconds(*two, clock="real_time"),
            2 * results.seconds(*one) / results.seconds(*two))


def stages(results, subject):
    dot, loads = limits(results)
    rows = []
    for cell in results.values("sweep", subject, "cell"):
        for rays in reversed(results.values("sweep", subject, "rays")):
            key = sweep_key(subject, rays, cell, "half")
            if not results.has(*key):
                continue
            run, total = results.best(*key), results.seconds(*key)
            parts = [run[f"{stage}_s"] for stage in ("layout", "march", "lookup", "filter")]
            march = run["voxel_steps"] / run["march_s"]
            both = run["voxel_steps"] / (run["layout_s"] + run["march_s"])
            two = sweep_key(subject, rays, cell, "half", 2)
            wall = "–"
            if results.has(*two):
                by_wall, by_work = speed_up(results, key, two)
                wall = f"{seconds(results, *two, clock='real_time')} ({by_wall:.2f}×, {by_work:.2f}×)"
            rows.append([squared(rays), str(cell), number(total), *[number(share) for share in parts], number(max(0.0, total - sum(parts))),
                         f"{march / 1e9:.2f}", f"{both / 1e9:.2f}", f"{run['voxel_steps'] / total / 1e9:.2f}", f"{march / loads:.0%}", f"{march / dot:.0%}",
                         f"{run['cell_directions'] / total / 1e9:.2f}", wall])
    return markdown_rows(["rays", "cell", "sweep, s", "row pairs", "march", "lookup", "filter", "rest", "G steps/s, march", "with row pairs",
                          "whole sweep", "of the load limit",
                          "of the dot limit", "G values of V/s", "two threads, wall s"], rows)


def preparation(results):
    rows = []
    isa = machine(results)
    dram = results.rate("bytes_per_second", "machine", isa, "read", "DRAM", "aligned")
    for subject in NAMES:
        for level in results.values("prepare", subject, "mip"):
            straight, both = prepare_key(subject, level, "straight"), prepare_key(subject, level)
            run, time = results.best(*both), results.seconds(*both)
            moved = run["volume_bytes"] + run["extinction_bytes"]
            rows.append([NAMES[subject], str(level), number(1e3 * results.seconds(*straight)),
                         number(1e3 * max(0.0, time - results.seconds(*straight))), number(1e3 * time),
                         milliseconds(results, *prepare_key(subject, level, threads=2), clock="real_time"),
                         number(run["extinction_bytes"] / 1e6), f"{moved / time / 1e9:.2f}", f"{moved / time / dram:.0%}"])
    return markdown_rows(["volume", "mip level", "classify, ms", "layouts, ms", "both, ms", "two threads, wall ms", "MB kept",
                          "GB/s read and written", "of DRAM read"], rows)


def products(results):
    rows = []
    for subject in NAMES:
        for cell in results.values("product", subject, "cell"):
            key = ("product", subject, f"cell:{cell}", "threads:1")
            run, time = results.best(*key), results.seconds(*key)
            rows.append([NAMES[subject], str(cell), number(time), seconds(results, *key[:3], "threads:2", clock="real_time"),
                         number(run["grid_bytes"] / 1e6), number(run["joint_bytes"] / 1e6),
                         f"{(run['grid_bytes'] + run['joint_bytes']) / time / 1e9:.2f}"])
    return markdown_rows(["volume", "cell", "product, s", "two threads, wall s", "V, MB", "product, MB", "GB/s"], rows)


def errors(results):
    rows = []
    for subject in NAMES:
        for cell in results.values("sweep", subject, "cell"):
            for rays in reversed(results.values("sweep", subject, "rays")):
                pair = [sweep_key(subject, rays, cell, filter_) for filter_ in ("none", "half")]
                if not all(results.has(*key) and "rms" in results.best(*key) for key in pair):
                    continue
                plain, filtered = (results.best(*key) for key in pair)
                oversampled = sweep_key(subject, rays, cell, "4x")
                rows.append([NAMES[subject], squared(rays), str(cell), with_error(plain, "rms"), with_error(filtered, "rms"),
                             with_error(plain, "rms_averaged"), with_error(filtered, "rms_averaged"),
                             with_error(results.best(*oversampled), "rms_averaged") if results.has(*oversampled) else "–"])
    return markdown_rows(["volume", "rays", "cell", "exact, no filter", "exact, filtered", "averaged, no filter", "averaged, filtered",
                          "averaged, 4× directions"], rows)


def with_error(run, name):
    return f"{run[name]:.4f} ± {run[name + '_error']:.4f}"


def targets(results):
    """Each target: what was to be had, what was measured, the verdict."""
    ct = "ct"
    rows = []

    def at_most(what, limit, value, unit):
        rows.append([what, f"≤ {limit} {unit}".rstrip(), number(value) if unit else f"{value:.4f}", "met" if value <= limit else "MISSED"])

    def at_least(what, limit, value):
        rows.append([what, f"≥ {limit}×", f"{value:.3g}×", "met" if value >= limit else "MISSED"])

    most = sweep_key(ct, 512, 4, "half")
    at_most("512² rays to 128 × 128 × 115 cells, filtered", 0.50, results.seconds(*most), "s")
    at_most("512² rays to 64 × 64 × 57 cells, filtered", 0.35, results.seconds(*sweep_key(ct, 512, 8, "half")), "s")
    at_most("256² rays to 128 × 128 × 115 cells, filtered", 0.25, results.seconds(*sweep_key(ct, 256, 4, "half")), "s")
    for level in (0, 1):
        at_most(f"preparation, mip level {level}, all layouts", 0.08, results.seconds(*prepare_key(ct, level)), "s")
    for clock, value in zip(("wall-clock time", "processor time"), speed_up(results, most, sweep_key(ct, 512, 4, "half", 2))):
        at_least(f"two threads, 512² to 128 × 128 × 115, by {clock}", 1.8, value)
    for subject in (ct, "smoke"):
        for rays, what in ((512, "512²"), (256, "256² (what `auto` takes)")):
            at_least(f"faster than our brute force, {NAMES[subject]}, {what}, filtered, cells of 4³", 200,
                     brute_force_seconds(results, subject, 4)[0] / results.seconds(*sweep_key(subject, rays, 4, "half")))
    for subject, exact, averaged, prototype in ((ct, 0.010, 0.053, 0.0615), ("smoke", 0.002, 0.045, 0.0563)):
        plain, filtered = (results.best(*sweep_key(subject, 512, 4, filter_)) for filter_ in ("none", "half"))
        for what, limit, value in ((f"rms against exact, {NAMES[subject]}, 512², cells of 4³, no filter", exact, plain["rms"]),
                                   (f"rms against cell-and-texel averages, {NAMES[subject]}, filtered", averaged, filtered["rms_averaged"])):
            at_most(what, limit, value, "")
            at_most("… over this volume's own contrast", round(limit / prototype, 3), value / plain["rms_averaged"], "")
    return markdown_rows(["target", "wanted", "measured", "verdict"], rows)


PREFACE = """# Visibility sweeps against the machine and the papers

Measured on {processor} ({cores} cores), {isa}, commit {commit}, {date}, in {minutes:.1f} minutes; the load average was {load_before:.1f} before and
{load_after:.1f} after (1 is one busy core; this run itself makes up to 2). {loaded}
Volumes: a generated CT-like head and a smoke-like plume, {size}, 16 bits; ch2better, a real MR in 8 bits.
64 directions. Seconds are processor time of one thread, the least of several repetitions, which find the working memory of the one before
(the first also takes it from the system, up to 40 % more); so are their parts, by the program's own clock.
Two threads: wall-clock seconds, how many times faster than one by that clock, and what processor time says: twice that of one thread over
that of both together, waiting included, which other work on the machine disturbs less. Regenerate with `studies/sweeps.py`{how}.
"""


def report(results):
    study, quick = results.study, results.study["quick"]
    loaded = "Other work ran on the machine: trust ratios more than times." if study["load_before"] > 0.5 else "The machine was idle."
    text = [PREFACE.format(**study, isa=machine(results), loaded=loaded, size="64 × 64 × 57 (a trial run)" if quick else "512 × 512 × 460",
                           how=" without `--quick`" if quick else "")]
    if not quick:
        text += ["## Targets", "", targets(results), "",
                 "A volume's contrast is how far V at the centres of cells and texels is from its averages (rms, unfiltered 512²), which no sweep changes.",
                 "The targets were set on another generated CT with .0615, and smoke with .0563; the real scans in `scenes/` have .13 (CT head), .19",
                 "(stent) and .09 (ch2). The lines with … take the errors and the targets relative to it.", ""]
    text += ["## The machine's own limits", "",
             "Reads are in steps of 64 bytes, aligned / two bytes off. A quad is four products of an 8-bit voxel with an 8-bit weight and",
             "their sum: one voxel step. The load limit below is one unaligned 64-byte read from L1, which holds 16 quads.", "",
             ceilings(results), ""]
    for subject in ("ct", "smoke", "ch2better"):
        if results.values("sweep", subject, "rays"):
            text += [f"## Where the time goes: {NAMES[subject]}", "", stages(results, subject), ""]
    text += ["## Preparation", "",
             "From a new transfer function to what sweeps march through, into the memory of the one before: the volume is read once, extinction",
             "written, and its transposed copy.",
             "", preparation(results), "",
             "## Product with the light", "", products(results), ""]
    text += sweeps_table_1.section(results) + sweeps_table_2.section(results)
    text += ["## Errors", "",
             "Root mean square over all directions of cells taken at random" + f" (seed {results.context['reference_seed']}), ± the standard error of that",
             "choice. Exact: V at cell and texel centres in the same classified volume at full resolution. Averaged: V averaged over cell and texel.",
             "The filter aims at the average, so it moves away from the exact value.", "", errors(results), ""]
    return "\n".join(text).rstrip() + "\n"

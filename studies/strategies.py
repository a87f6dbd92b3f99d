#!/usr/bin/python3
"""How much noise each direction strategy leaves, at equal samples and at equal time.

For every scene and light the papers' five strategies and "auto" are rendered at several sample counts and compared with a reference made by
two-step sampling from another seed. Writes strategies.md, strategies.csv and one picture per scene and light. Runs are cached
in out/strategies, so that an interrupted study goes on where it was.

    studies/strategies.py                    the study of docs/results/strategies.md
    studies/strategies.py --quick            a table in a minute or two, printed and written to out/
"""
import argparse
import csv
import json
import math
import sys
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import pictures
from common import (ROOT, Renderer, StudyError, divide, markdown_rows, mean_and_error, need_inputs, processor, ratio,
                    with_error)

PAPERS = ["uniform", "environment", "visibility", "combined", "two-step"]
STRATEGIES = [*PAPERS, "auto"]
BASELINE = "environment"
REFERENCE_SEED = 900000


# --- measuring ------------------------------------------------------------------------------------------------------------

PREPARATION = ("classify", "sweep", "joint")


def measure(renderer, scene, light, plan, reference_samples, report):
    """Rows of measurements, and the picture stems of one run per strategy."""
    report(f"{scene} under {light}: reference of {reference_samples} samples")
    reference, _ = renderer.render(scene, light, "two-step", reference_samples, REFERENCE_SEED)
    rows, shown = [], {"reference": reference}
    for strategy in STRATEGIES:
        for samples, repeats in plan.items():
            report(f"{scene} under {light}: {strategy}, {samples} samples")
            for repeat in range(repeats):
                # Runs of one seed share their first samples, so every sample count has seeds of its own.
                stem, stats = renderer.render(scene, light, strategy, samples, 100 * samples + repeat)
                result = renderer.compare(stem, reference)
                seconds = stats["seconds"]
                rows.append({"scene": scene, "light": light, "strategy": strategy, "samples": samples, "repeat": repeat,
                             "mse": result["mse"], "relmse": result["relmse"], "render_s": seconds["render"],
                             "preparation_s": sum(seconds.get(stage, 0.0) for stage in PREPARATION),
                             "paths": stats["paths"], "isa": stats["isa"], "threads": stats["threads"]})
                if repeat == 0 and samples == min((16, *plan), key=lambda n: abs(n - 16)):
                    shown[strategy] = stem
    return rows, shown


def reference_variance(rows, reference_samples):
    """The reference's own part of every error. MSE(N) = v/N + v_ref/N_ref, and for two-step v = v_ref."""
    own = [row for row in rows if row["strategy"] == "two-step"]
    return {error: sum(row[error] / (1 / row["samples"] + 1 / reference_samples) for row in own) / len(own) / reference_samples
            for error in ("mse", "relmse")}


def summarise(rows, reference_samples):
    """Per strategy: MSE and its error by sample count, cost of a sample, and ratios to the baseline (above 1 is better)."""
    noise_of_reference = reference_variance(rows, reference_samples)
    summary = {}
    for strategy in STRATEGIES:
        own = [row for row in rows if row["strategy"] == strategy]
        by_samples, relative_by_samples = defaultdict(list), defaultdict(list)
        for row in own:
            by_samples[row["samples"]].append(row["mse"] - noise_of_reference["mse"])
            relative_by_samples[row["samples"]].append(row["relmse"] - noise_of_reference["relmse"])
        total_samples = sum(row["samples"] for row in own)
        # The variance of one sample, each run weighted by its samples; runs of several counts estimate the same number.
        variance = sum(row["samples"] * (row["mse"] - noise_of_reference["mse"]) * row["samples"] for row in own) / total_samples
        summary[strategy] = {
            "mse": {samples: mean_and_error(values) for samples, values in by_samples.items()},
            "relmse": {samples: mean_and_error(values) for samples, values in relative_by_samples.items()},
            "variance": variance,
            # Other load on the machine only ever adds: the fastest of the longer runs.
            "sample_s": min(row["render_s"] / row["samples"] for row in own if row["samples"] >= max(by_samples) / 4),
            "preparation_s": min(row["preparation_s"] for row in own),
        }
    baseline = summary[BASELINE]
    for entry in summary.values():
        entry["equal_samples"] = {n: ratio(baseline["mse"][n], entry["mse"][n]) for n in entry["mse"]}
        entry["equal_samples_relative"] = {n: ratio(baseline["relmse"][n], entry["relmse"][n]) for n in entry["relmse"]}
        entry["equal_time"] = divide(baseline["variance"] * baseline["sample_s"], entry["variance"] * entry["sample_s"])
        entry["equal_time_swept"] = {n: swept(baseline, entry, n) for n in entry["mse"]}
    return summary


def swept(baseline, entry, samples):
    """Ratio of MSE when the baseline is given the time that `entry` takes for its preparation and `samples` samples."""
    time = entry["preparation_s"] + samples * entry["sample_s"] - baseline["preparation_s"]
    baseline_samples = max(time / baseline["sample_s"], 1e-9)
    return divide(baseline["variance"] / baseline_samples, entry["variance"] / samples)


# --- reporting ------------------------------------------------------------------------------------------------------------

def markdown_tables(summary, counts):
    errors = [[strategy, *[with_error(*summary[strategy]["mse"][n]) for n in counts],
               f"{1000 * summary[strategy]['sample_s']:.3g}", f"{summary[strategy]['preparation_s']:.2f}"]
              for strategy in STRATEGIES]
    last = max(counts)
    ratios = [[strategy, *[with_error(*summary[strategy]["equal_samples"][n]) for n in counts],
               with_error(*summary[strategy]["equal_samples_relative"][last]),
               f"{summary[strategy]['equal_time']:.3g}", *[f"{summary[strategy]['equal_time_swept'][n]:.3g}" for n in counts]]
              for strategy in STRATEGIES]
    return "\n\n".join([
        markdown_rows(["strategy", *[f"MSE at {n}" for n in counts], "ms a sample", "preparation, s"], errors),
        markdown_rows(["strategy", *[f"ratio at {n}" for n in counts], f"relMSE ratio at {last}", "equal time", *[f"with sweep, {n}" for n in counts]], ratios)])


def two_step_table(results, samples):
    """The comparison that matters, scene by scene, and its geometric mean."""
    columns = []
    for summary in results.values():
        entry = summary["two-step"]
        columns.append((entry["equal_samples"][samples][0], entry["equal_samples_relative"][samples][0], entry["equal_time"],
                        entry["equal_time_swept"][samples]))
    means = [math.exp(sum(math.log(column[i]) for column in columns) / len(columns)) for i in range(4)]
    rows = [[f"{scene}, {light}", *[f"{value:.2f}" for value in column]] for (scene, light), column in zip(results, columns)]
    return markdown_rows(["scene", f"ratio at {samples}", "relMSE ratio", "equal time", f"with sweep, {samples}"],
                         [*rows, ["geometric mean", *[f"{value:.2f}" for value in means]]])


def plain_table(results, counts):
    last = max(counts)
    columns = [f"MSE at {last}", "equal samples", "relMSE", "equal time", "with sweep"]
    lines = [f"{'scene, light':22}{'strategy':14}" + "".join(f"{column:>15}" for column in columns)]
    for (scene, light), summary in results.items():
        for strategy in STRATEGIES:
            entry = summary[strategy]
            place = f"{scene}, {light}" if strategy == STRATEGIES[0] else ""
            ratios = (entry["equal_samples"][last][0], entry["equal_samples_relative"][last][0], entry["equal_time"],
                      entry["equal_time_swept"][last])
            lines.append(f"{place:22}{strategy:14}{entry['mse'][last][0]:15.3g}" + "".join(f"{value:14.3g}x" for value in ratios))
    lines.append(f"Ratios: how many times less squared error than '{BASELINE}', which samples the light alone. relMSE divides each")
    lines.append("pixel's squared error by the reference's square, so that shadows count like highlights.")
    return "\n".join(lines)


PREFACE = """# Noise of the direction strategies

Squared error against a reference of {reference} samples a pixel (two-step, another seed), mean over the pixels and channels of
{width} × {width} images whose background is hidden, so that only the volume's shading counts. The reference's own variance,
known from two-step's error at small counts, is subtracted. ± is the standard error over runs of different seeds.

- **ratio at N**: the error of environment sampling over that of the strategy, at equal samples; above 1 is better.
- **relMSE ratio**: the same for squared errors divided by the squared reference (plus 0.01), so that shadows count like
  highlights.
- **equal time**: the ratio for variance × time, rendering alone. Times are the fastest of several runs, as other load on
  the machine only ever adds.
- **with sweep, N**: the same when the strategy's preparation (classification, sweeps, joint grid) and N samples are paid, and
  environment sampling gets all of that time for samples.

Measured on {processor}, {threads} threads, {isa}. Regenerate with `{command}`.
"""


def write_report(folder, results, rows, shown, plan, options):
    folder.mkdir(parents=True, exist_ok=True)
    counts = sorted(plan)
    with open(folder / "strategies.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    text = [PREFACE.format(reference=options.reference_samples, width=options.width, processor=processor(),
                           threads=rows[0]["threads"], isa=rows[0]["isa"], command=options.command)]
    text += ["## Two-step against environment sampling", "", two_step_table(results, max(counts)), ""]
    for (scene, light), summary in results.items():
        picture = f"strategies-{scene}-{light}.png"
        pictures.write_comparison(folder / picture, {name: Path(f"{stem}.png") for name, stem in shown[scene, light].items()},
                                  PAPERS)
        text += [f"## {scene} under {light}", "", markdown_tables(summary, counts), "",
                 f"![{scene} under {light}]({picture})", "",
                 "Left the reference; right the framed part magnified: uniform, environment, visibility above; combined,",
                 "two-step, reference below.", ""]
    (folder / "strategies.md").write_text("\n".join(text).rstrip() + "\n")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small images, few samples, two scenes")
    parser.add_argument("--scenes", nargs="+", default=None, help="names in scenes/ (ct_head stent ch2)")
    parser.add_argument("--lights", nargs="+", default=None, help="names in data/environments (courtyard studio city sunrise)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="scene entry to change; repeatable")
    parser.add_argument("--width", type=int, default=None, help="pixels along each side (256)")
    parser.add_argument("--reference-samples", type=int, default=None, help="of the reference (8192)")
    parser.add_argument("--program", default=ROOT / "build" / "release" / "lumisweep")
    parser.add_argument("--output", type=Path, default=None, help="folder of the report (docs/results)")
    parser.add_argument("--cache", type=Path, default=ROOT / "out" / "strategies", help="folder of images (out/strategies)")
    parser.add_argument("--fresh", action="store_true", help="render references again, too")
    options = parser.parse_args()
    quick = options.quick
    options.scenes = options.scenes or (["ct_head", "stent"] if quick else ["ct_head", "stent", "ch2"])
    options.lights = options.lights or (["sunrise"] if quick else ["courtyard", "studio", "city", "sunrise"])
    options.width = options.width or (160 if quick else 256)
    options.reference_samples = options.reference_samples or (1024 if quick else 8192)
    options.output = options.output or ROOT / ("out" if quick else "docs/results")
    # Sample count: runs of different seeds.
    options.plan = {16: 2, 64: 1} if quick else {4: 8, 16: 4, 64: 3, 256: 2}
    options.command = " ".join(["studies/strategies.py", *sys.argv[1:]])
    return options


def main():
    options = parse_arguments()
    need_inputs(options.scenes, options.lights)
    renderer = Renderer(options.program, options.cache, options.width, options.set)
    if options.fresh:
        for path in options.cache.glob("*-two-step-*"):
            path.unlink()

    def report(line):
        print(line, file=sys.stderr, flush=True)

    rows, results, shown = [], {}, {}
    for scene in options.scenes:
        for light in options.lights:
            found, shown[scene, light] = measure(renderer, scene, light, options.plan, options.reference_samples, report)
            rows += found
            results[scene, light] = summarise(found, options.reference_samples)
    write_report(options.output, results, rows, shown, options.plan, options)
    print(plain_table(results, sorted(options.plan)))
    print(f"Report: {options.output / 'strategies.md'}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError, KeyError, json.JSONDecodeError) as error:
        print(f"strategies: {error!r}" if isinstance(error, KeyError) else f"strategies: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)

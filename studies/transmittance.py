#!/usr/bin/python3
"""Which estimator of transmittance towards the light a renderer should have: docs/results/transmittance.md.

Runs lumisweep_bench --transmittance, which follows the renderer's own shadow rays through opaque and thin media and takes the
variance and the CPU time of each estimator, along the rays and within a whole render. About ten minutes.

    studies/transmittance.py                      measures, writes docs/results/transmittance.md, keeps the numbers in out/
    studies/transmittance.py --from FILE.json     writes the report of an earlier run again
    studies/transmittance.py --quick              small volumes, some seconds, into out/: does it all still work?
"""
import argparse
import json
import math
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from common import ROOT, StudyError, commit, cores, geometric_mean, load, markdown_rows, need_program, processor

BASE = "ratio:0.1"
NAMES = {
    "ratio:0.1": "ratio tracking, roulette below 0.1",
    "delta": "delta tracking",
    "ratio:none": "ratio, no roulette",
    "ratio:0.03": "ratio, 0.03",
    "ratio:0.25": "ratio, 0.25",
    "ratio:0.5": "ratio, 0.5",
    "ratio:1": "ratio, 1 (from the start)",
    "ratio:image:0.1": "ratio, 0.1 of the image's mean by weight",
    "ratio:image:0.3": "ratio, 0.3 of the image's mean",
    "ratio:image:1": "ratio, the image's mean",
    "ratio:pixel:0.1": "ratio, 0.1 of the pixel's mean by weight",
    "ratio:pixel:0.3": "ratio, 0.3 of the pixel's mean",
    "ratio:pixel:1": "ratio, the pixel's mean",
    "residual:none": "residual ratio, no roulette",
    "residual:0.1": "residual ratio, 0.1",
    "residual:0.5": "residual ratio, 0.5",
    "residual:1": "residual ratio, 1",
    "centred:0.1": "residual ratio, centred in thin cells, 0.1",
    "centred:0.25": "residual ratio, centred in thin cells, 0.25",
    "march": "unbiased ray marching",
    "march:bounded:0.1": "the same beyond the cells' minimum, 0.1",
    "march:bounded:1": "the same, 1",
}
MEDIA = {"ct_head": "CT head", "stent": "stent", "ch2": "ch2", "ct": "CT-like", "smoke:3": "smoke, τ ≈ 3", "smoke:390": "smoke, τ ≈ 390",
         "smoke:3900": "smoke, τ ≈ 3900"}


def cases(measured):
    """{(medium, strategy): {estimator: counters}} in the order of measuring."""
    found = {}
    for run in measured["benchmarks"]:
        if run.get("run_type", "iteration") == "iteration":
            _, medium, strategy, estimator = run["run_name"].split("/")[:4]
            found.setdefault((medium, strategy), {})[estimator] = run
    return found


def image_cost(run, k):
    return run[f"image_variance_{k}"] * run[f"image_s_{k}"]


def ratio(a, b):
    return a / b if b > 0 and a > 0 else math.nan


def cell(value, is_best=False):
    text = "–" if math.isnan(value) else f"{value:.2f}" if value < 9.95 else f"{value:.0f}"
    return f"**{text}**" if is_best else text


def table(found, strategy, value):
    """Estimators by media, relative to the base; the best of each medium in bold; the geometric mean last."""
    media = [medium for medium, s in found if s == strategy]
    values = {e: [ratio(value(found[medium, strategy][e]), value(found[medium, strategy][BASE])) for medium in media] for e in NAMES}
    best = [min((v[i] for v in values.values() if not math.isnan(v[i])), default=math.nan) for i in range(len(media))]
    rows = [[NAMES[e], *(cell(x, x == best[i]) for i, x in enumerate(v)),
             cell(geometric_mean(v) if not any(map(math.isnan, v)) else math.nan)] for e, v in values.items()]
    return markdown_rows(["estimator", *(MEDIA.get(m, m) for m in media), "mean"], rows)


def scenes(found):
    rows = []
    for (medium, strategy), runs in found.items():
        run = runs[BASE]
        rows.append([MEDIA.get(medium, medium), strategy, f"{run['mean_transmittance']:.2f}", f"{run['rays_per_path']:.2f}",
                     f"{1e9 * run['camera_s']:.0f}", f"{1e9 * run['direction_s']:.0f}", f"{1e9 * run['ray_s']:.0f}",
                     f"{run['cells']:.0f}", f"{run['lookups']:.1f}", f"{runs['march']['lookups']:.0f}"])
    return markdown_rows(["medium", "directions", "mean T", "shadow rays a path", "camera, ns", "direction, ns", "shadow ray, ns", "cells",
                          "lookups", "lookups, marching"], rows)


def by_weight(found):
    """Roulette by weight where directions fit the light badly: same variance as without roulette, in less time."""
    rows = []
    for (medium, strategy), runs in found.items():
        for name in ("ratio:image:0.3", "ratio:image:1"):
            run, none, base = runs[name], runs["ratio:none"], runs[BASE]
            rows.append([MEDIA.get(medium, medium), strategy, NAMES[name],
                         cell(ratio(run["image_variance_1"], none["image_variance_1"])), cell(ratio(run["image_s_1"], base["image_s_1"]))])
    return markdown_rows(["medium", "directions", "estimator", "variance, against no roulette", "time, against a threshold of 0.1"], rows)


TEXT = """# Transmittance towards the light

Which estimator of T = exp(−∫σ) shadow rays should have, by variance × CPU time. `studies/transmittance.py` measures it and writes
this page. {machine}.

The rays are the renderer's own: its stages take camera rays to their first collisions and choose directions there. The media are the
public scenes and the generated volumes of `bench/volumes.h`, under `sunrise` (ch2: `studio`), 160 × 160 pixels, 8 samples. Every estimator is a stage
for 16 lanes in a stream of 1024 rays, with majorants in cells of 2³ voxels and without the renderer's jumps over empty space. Each ray is
estimated 6 times; estimators take turns, and the quickest turn counts. `bench/transmittance_test.cpp` holds the mean of each against quadrature
in double precision, at optical depths up to thousands.

{scenes}

## Estimators
- **Delta tracking** (Woodcock 1965): 0 or 1.
- **Ratio tracking** (Novák et al. 2014) with roulette below a threshold of T. A threshold of 1 is delta tracking by another name.
- **Roulette by weight**: the threshold is a share of the mean contribution of a shadow ray, over the image or the pixel, divided by
  the ray's weight. The means come from samples of their own.
- **Residual ratio tracking** (the same paper): each cell's smallest extinction in closed form. *Centred*: half-way between the smallest
  and the largest in cells whose bounds differ by less than 0.1 of optical depth; a lookup's factor is then in [0, 2], and lookups and
  variance halve.
- **Unbiased ray marching** (Kettunen et al. 2021): combs of equidistant lookups, the number of them and the roulette of orders as in the
  paper, with equidistance in the optical depth of the majorants, so that empty space takes no lookups. It goes through the cells twice: once for the
  majorants' optical depth. Without the paper's matching of end points. *Beyond the cells' minimum*: of what exceeds the smallest
  extinction, with roulette by the closed part before the march.

All tables are relative to ratio tracking with a threshold of 0.1, which the renderer had before; smaller is better.

## T alone
Variance of T along a ray × time of the ray, mean over the rays of `two-step`:

{rays}

Marching has the least variance by far and wins here. But an image has little of that: V differs much more between directions, and collisions
between samples.

## The image
Variance of a pixel's sample × its time (camera segment, direction, shadow ray), `two-step`:

{image_two-step_1}

Two shadow rays per collision, and four:

{image_two-step_2}

{image_two-step_4}

## Roulette by weight
{weight}

Where directions fit the light badly, dim rays need not be followed far, and up to 40 % of the time is saved at equal variance. With `two-step`
weights are alike, and what is saved is less than a constant threshold of 0.25 saves. The mean of the image has to be known, which costs
a pilot pass and a number in every checkpoint. It is not in the renderer.

## What the renderer has
- **Ratio tracking, roulette below 0.25.** Against 0.1 it saves 2 to 5 % in all media, 8 to 10 % with several shadow rays. Below 0.1 is worse; 0.5 is
  worse with one shadow ray per collision, and no better than 0.25 with two. In the renderer with strategy `auto`, which has three per camera
  ray, 0.5 is 4 to 5 % worse (CT head and stent, `courtyard` and `sunrise`).
- **In thin media, residual ratio tracking with the least extinction of a block as control.** Thin is a medium in which the mean majorant of what is not
  empty, times the volume's diagonal, is at most 32 (`thin_medium`). There T's own variance is most of the image's. In opaque media the second lookup
  per cell costs 2 to 10 % and nothing is gained, so they are rendered without. Volumes with voxels that are not finite count as opaque. A centred control is a
  little better where a medium is even (0.51 against 0.59 for smoke above), but in thin shells, whose blocks are mostly empty, its factors of 2 pile up to 16
  times the variance, which `studies/efficiency.py` found.
- Delta tracking takes half of the time of a shadow ray but brings up to twice the variance of a pixel; with four shadow rays per
  collision it draws level, and 0.25 to 0.5 are still better.
- Marching loses in opaque media by its hundreds of lookups, and in thin ones to the residual estimator, which walks once.

Optical depths of thousands: T is a product that reaches 0 or the roulette, each lookup ends a ray with a probability of at least σ/majorant below the
threshold, and the closed part's exponential ends at e^−87. Nothing depends on 1/T.
"""


def report(measured):
    found, study = cases(measured), measured["study"]
    text = TEXT
    parts = {
        "machine": f"{study['processor']}, one of {study['cores']} cores, {study['date']}, commit {study['commit']}, "
                   f"{measured['context']['instruction_set']}, load {study['load_before']:.1f}",
        "scenes": scenes(found),
        "rays": table(found, "two-step", lambda run: run["variance"] * run["ray_s"]),
        "weight": by_weight(found),
        **{f"image_two-step_{k}": table(found, "two-step", lambda run, k=k: image_cost(run, k)) for k in (1, 2, 4)},
    }
    for name, value in parts.items():
        text = text.replace("{" + name + "}", value)
    return text


def measure(options):
    program = need_program(options.program)
    arguments = [program, "--transmittance", "--benchmark_format=json", *(["--quick"] if options.quick else []), "--data", options.data]
    study = {"processor": processor(), "cores": cores(), "commit": commit(), "date": time.strftime("%Y-%m-%d"), "load_before": load()}
    run = subprocess.run([*map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if run.returncode != 0:
        raise StudyError(f"{program.name} failed ({run.returncode})")
    return {**json.loads(run.stdout), "study": study}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small volumes, few samples")
    parser.add_argument("--from", dest="earlier", type=Path, metavar="FILE", help="numbers of an earlier run (out/transmittance.json)")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "lumisweep_bench")
    parser.add_argument("--data", type=Path, default=ROOT / "data", help="folder of the fetched volumes and lights")
    parser.add_argument("--output", type=Path, default=None, help="the report (docs/results/transmittance.md)")
    options = parser.parse_args()
    output = options.output or ROOT / ("out/transmittance-quick.md" if options.quick else "docs/results/transmittance.md")
    if options.earlier:
        measured = json.loads(options.earlier.read_text())
    else:
        measured = measure(options)
        kept = output.with_suffix(".json") if options.quick else ROOT / "out" / "transmittance.json"
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(measured, indent=1))
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(report(measured), encoding="utf-8")
    print(f"Report: {output}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError, KeyError, json.JSONDecodeError) as error:
        print(f"transmittance: {error!r}" if isinstance(error, KeyError) else f"transmittance: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)

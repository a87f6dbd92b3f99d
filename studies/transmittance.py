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


def report(measured):
    found, study = cases(measured), measured["study"]
    text = (ROOT / "studies" / "transmittance.txt").read_text(encoding="utf-8")
    parts = {
        "machine": f"{study['processor']}, one of {study['cores']} cores, {study['date']}, commit {study['commit']}, "
                   f"{measured['context']['instruction_set']}, load {study['load_before']:.1f}",
        "scenes": scenes(found),
        "rays": table(found, "two-step", lambda run: run["variance"] * run["ray_s"]),
        **{f"image_{s}_{k}": table(found, s, lambda run, k=k: image_cost(run, k))
           for s, k in (("two-step", 1), ("two-step", 2), ("two-step", 4), ("uniform", 1))},
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

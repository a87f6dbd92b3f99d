#!/usr/bin/python3
"""What a GPU does beside its limits and beside the CPU: docs/results/cuda.md.

    studies/cuda.py                       runs build/release/lumisweep_device_bench on this machine's GPU, writes the report and
                                          keeps the numbers in out/cuda.json
    studies/cuda.py --from FILE.json      writes the report of an earlier run, or of another machine's (bench/cuda/pack)
    studies/cuda.py --quick --device cpu  small volumes, on the CPU, into out/: does it all still work?
"""
import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from common import ROOT, StudyError, markdown_rows

TEXT = """# The GPU

Measured on {where}, {date}, commit {commit}. Regenerate with `studies/cuda.py` on a machine with a GPU, or pack what it takes with
`bench/cuda/pack`, run it there, and give its numbers to `studies/cuda.py --from`.

## What the device can do

{ceilings}

## The same paths as the CPU

One sample a pixel beside the CPU's scalar instantiation: the same random numbers and stages, so the same sample unless a rounding has decided otherwise on the way.
Then the means of independent samples (another seed on the CPU): green, over all pixels.

{equality}

## An edit of the transfer function

Generated CT-like volume, directions 8². Milliseconds, the least of 30 edits (median): majorants, classification, sweep, product with the light. Rays: their
number along the longer side.

{edits}

{first_sample}

## Paths a second

Images of 512², one sample after another for a second. Steps are tentative collisions a path, cells what a path goes through; utilisation is the share of a
warp's lanes that worked.

{paths}

## A time series

{series}
"""


def milliseconds(summary):
    return f"{1e3 * summary['least']:.2f} ({1e3 * summary['median']:.2f})"


def edits(runs, ceilings):
    rows = []
    for run in runs:
        seconds = run["seconds"]
        row = [str(run["rays"]), str(run["cell"]), run["filter"], *[milliseconds(seconds[part]) for part in ("majorants", "classify", "sweep", "joint")],
               f"{run['voxel_steps_per_s'] / 1e9:.0f}"]
        if ceilings:
            row.append(f"{100 * 2 * run['voxel_steps_per_s'] / ceilings['byte_products_per_s']:.0f} %")
        rows.append(row)
    head = ["rays", "cell", "filter", "majorants", "classify", "sweep", "joint", "10⁹ steps/s"]
    return markdown_rows(head + (["of byte products"] if ceilings else []), rows)


def report(numbers, commit):
    ceilings = numbers.get("ceilings")
    date = time.strftime("%Y-%m-%d", time.gmtime(numbers["time"]))
    where = f"{ceilings['name']} (driver of CUDA {ceilings['driver_of_cuda']}, runtime {ceilings['runtime']})" if ceilings else f"the CPU ({numbers['isa']})"
    ceiling_rows = "Measured for a GPU only."
    if ceilings:
        ceiling_rows = markdown_rows(
            ["multiprocessors", "memory", "copy within, GB/s read and written", "upload, GB/s", "10¹² byte products/s"],
            [[str(ceilings["multiprocessors"]), f"{ceilings['memory'] / 2**30:.0f} GiB", f"{ceilings['copy_bytes_per_s'] / 1e9:.0f}",
              f"{ceilings['upload_bytes_per_s'] / 1e9:.1f}", f"{ceilings['byte_products_per_s'] / 1e12:.1f}"]])
    equality = [[run["scene"], f"{100 * run['equal_to_the_bit']:.2f} %", f"{100 * run['same_samples']:.2f} %",
                 f"{run['means_differ']:+.5f} ± {run['standard_error']:.5f}"] for run in numbers["equality"]]
    first = numbers["first_sample"]
    paths = [[run["scene"], run["strategy"], f"{run['paths_per_s'] / 1e6:.1f}", f"{run['shadow_rays_per_s'] / 1e6:.1f}", f"{run['camera_steps']:.1f}",
              f"{run['shadow_steps']:.1f}", f"{run['advance_steps']:.1f}", f"{100 * run['advance_utilisation']:.0f} %",
              f"{100 * run['candidate_utilisation']:.0f} %"] for run in numbers["paths"]]
    series = numbers["series"]
    return TEXT.format(
        where=where, date=date, commit=commit, ceilings=ceiling_rows,
        equality=markdown_rows(["scene", "equal to the bit", "within 1e-4", "mean, relative difference"], equality),
        edits=edits(numbers["edits"], ceilings),
        first_sample=f"From the edit to the first new sample of all {first['image'][0]}² pixels in the host's memory: {milliseconds(first['seconds'])} ms.",
        paths=markdown_rows(["scene", "strategy", "10⁶ paths/s", "10⁶ shadow rays/s", "camera steps", "shadow steps", "cells", "utilisation, cells", "collisions"], paths),
        series=f"Frames of {series['frame_bytes'] / 2**20:.0f} MiB, each swept anew and shown after one sample: {series['frames_per_s']:.1f} a second, and "
               f"{series['frames_per_s_ahead']:.1f} where the next one is copied meanwhile (`Session::prefetch`).")


def commit_here():
    return subprocess.run(["git", "-C", str(ROOT), "describe", "--always", "--dirty"], capture_output=True, text=True).stdout.strip() or "unknown"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small volumes")
    parser.add_argument("--device", choices=["cuda", "cpu"], default="cuda")
    parser.add_argument("--from", dest="earlier", type=Path, metavar="FILE", help="numbers of an earlier run; its commit in a file beside")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "lumisweep_device_bench")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    aside = options.quick or options.device == "cpu"
    output = options.output or (ROOT / "out" / "cuda.md" if aside else ROOT / "docs" / "results" / "cuda.md")
    if options.earlier:
        numbers = json.loads(options.earlier.read_text())
    else:
        run = subprocess.run([str(options.program), "--device", options.device, *(["--quick"] if options.quick else [])], capture_output=True, text=True)
        if run.returncode != 0:
            raise StudyError(f"{options.program.name}: {run.stderr.strip()}")
        numbers = json.loads(run.stdout)
        if not aside:
            kept = ROOT / "out" / "cuda.json"
            kept.parent.mkdir(exist_ok=True)
            kept.write_text(run.stdout)
    output.parent.mkdir(parents=True, exist_ok=True)
    beside = options.earlier.parent / "commit" if options.earlier else None
    commit = beside.read_text().strip() if beside and beside.is_file() else commit_here()
    output.write_text(report(numbers, commit))
    print(output)


if __name__ == "__main__":
    try:
        main()
    except StudyError as error:
        print(error, file=sys.stderr)
        sys.exit(1)

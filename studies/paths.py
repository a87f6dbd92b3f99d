#!/usr/bin/python3
"""How fast the render loop is, by scene and instruction set: docs/results/paths.md.

Runs the benchmarks "paths/..." of lumisweep_bench, which loads or generates the scenes. About five minutes; an idle machine,
please.

    studies/paths.py                      measures, writes docs/results/paths.md and keeps the numbers in out/paths.json
    studies/paths.py --from FILE.json     writes the report of an earlier run again
    studies/paths.py --quick              small volumes and images, some seconds, into out/: does it all still work?
"""
import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from benchmarks import Results, run_benchmarks
from common import ROOT, StudyError, geometric_mean, markdown_rows

TEXT = """# Paths a second

A path is a pixel's sample: camera segment, direction, shadow segment; those that miss the volume count, too. Images of 512² pixels, background
hidden, under the morning sun of the fetched lights (the analytic sky without them), strategy `two-step`, one shadow ray a path. One thread, the least
processor time of several passes; 2 threads: wall-clock time.

**camera** is a pass with albedo 0, so without shadow segments, and uniform directions; **direction** what two-step adds to
that pass; **shadow** the rest; each as a share of the whole. **collided**: the share of paths that do. Steps are tentative collisions a path. **lanes in use**: of the
groups that advance through cells, and of those at tentative collisions.

Measured on {processor}, {cores} cores, commit {commit}, {date}, {minutes:.0f} minutes. {loaded} Regenerate with `studies/paths.py`.

## Millions of paths a second and core

{speeds}

## Where the time goes ({isa})

{shares}
"""


def share(value):
    return f"{100 * value:.1f} %"


def report(results):
    scenes = list(dict.fromkeys(key[1] for key in results.runs))
    if not scenes:
        raise StudyError("no path was measured")
    isas = list(dict.fromkeys(key[2] for key in results.runs))
    best = isas[0]

    def rate(scene, isa, threads=1):
        return results.rate("paths_per_s", "paths", scene, isa, f"threads:{threads}")

    speeds = [[scene, *[f"{rate(scene, isa) / 1e6:.2f}" for isa in isas], f"{rate(scene, best, 2) / 1e6:.2f}",
               f"{rate(scene, best, 2) / rate(scene, best):.2f}"] for scene in scenes]
    speeds.append(["relative to the first, geometric mean",
                   *[f"{geometric_mean([rate(scene, isa) / rate(scene, best) for scene in scenes]):.2f}" for isa in isas], "",
                   f"{geometric_mean([rate(scene, best, 2) / rate(scene, best) for scene in scenes]):.2f}"])
    names = [isa.split(":")[1] for isa in isas]
    shares = []
    for scene in scenes:
        run = results.best("paths", scene, best, "threads:1")
        shares.append([scene, share(run["collided"]), f"{run['camera_steps']:.1f}", f"{run['shadow_steps']:.1f}", share(run["advance_utilisation"]), share(run["candidate_utilisation"]),
                       *[share(run[f"{part}_share"]) for part in ("camera", "direction", "shadow")]])
    study = results.study
    loaded = ("Other work ran on the machine: 2 threads say nothing, and trust ratios more than speeds."
              if study["load_before"] > 0.5 else "The machine was idle.")
    return TEXT.format(
        **study, loaded=loaded, isa=names[0], speeds=markdown_rows(["scene", *names, f"{names[0]}, 2 threads", "ratio"], speeds),
        shares=markdown_rows(["scene", "collided", "camera steps", "shadow steps", "lanes in use, advance", "candidate", "camera", "direction", "shadow"], shares))


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small volumes and images")
    parser.add_argument("--from", dest="earlier", type=Path, metavar="FILE", help="numbers of an earlier run (out/paths.json)")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "lumisweep_bench")
    parser.add_argument("--data", type=Path, default=ROOT / "data", help="fetched data; scenes without them are left out")
    parser.add_argument("--output", type=Path, default=None, help="the report (docs/results/paths.md)")
    options = parser.parse_args()
    options.output = options.output or ROOT / ("out/paths-quick.md" if options.quick else "docs/results/paths.md")
    return options


def main():
    options = parse_arguments()
    if options.earlier:
        measured = json.loads(options.earlier.read_text())
    else:
        print("Measuring" + ("" if options.quick else ", about five minutes"), file=sys.stderr, flush=True)
        measured = run_benchmarks(options, "^paths/")
        kept = options.output.with_suffix(".json") if options.quick else ROOT / "out" / "paths.json"
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(measured, indent=1))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(report(Results(measured)))
    print(f"Report: {options.output}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError, KeyError, json.JSONDecodeError) as error:
        print(f"paths: {error!r}" if isinstance(error, KeyError) else f"paths: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)

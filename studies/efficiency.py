#!/usr/bin/python3
"""Squared error by processor time of every direction strategy: docs/results/efficiency.md.

Every scene under every light is rendered on one thread by lumisweep_efficiency, by each strategy and by a plain scalar tracker, and
compared with a reference. Single runs are kept in out/efficiency, so that an interrupted study goes on where it was; about
twelve minutes on an idle machine.

    studies/efficiency.py                                   the study of docs/results/efficiency.md
    studies/efficiency.py --quick                           three scenes, a minute, into out/
    studies/efficiency.py --scenes stent --strategies environment two-step --lights city       a table, into out/

References are kept from build to build: the report says how far the means are from them. --fresh renders them again.
"""
import argparse
import csv
import hashlib
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import efficiency_report
from common import ROOT, StudyError, commit, light_file, need_program, processor, run_program, set_arguments

# What is measured: a name and the scene entries that make it. A new strategy is one line here.
STRATEGIES = {
    "uniform": ["render.strategy=uniform"],
    "environment": ["render.strategy=environment"],
    "visibility": ["render.strategy=visibility"],
    "combined": ["render.strategy=combined"],
    "two-step": ["render.strategy=two-step"],
    "auto": ["render.strategy=auto"],
    # What of auto's gain is not visibility's.
    "environment, stratified": ["render.strategy=environment", "render.random_numbers=stratified", "render.shadow_rays=3"],
}
SCALAR = "scalar"
REFERENCE = ["render.strategy=two-step"]
SCENES = ["ct_head", "stent", "ch2better", "plume", "ct_like", "smoke_like", "shells_2", "shells_400"]
LIGHTS = ["courtyard", "studio", "city", "sunrise"]
# A sun exactly behind what is seen (bench/scenes.h): hardly any of the light arrives.
BEHIND = "behind"
SCENES_FROM_BEHIND = ["ct_head", "shells_400"]
NO_DATA = 77


def digest(*parts):
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:10]


class Measurements:
    """Runs lumisweep_efficiency once per build, scene, light and strategy."""

    def __init__(self, options):
        self.options, self.program = options, need_program(options.program)
        self.build = hashlib.sha256(self.program.read_bytes()).hexdigest()[:12]
        options.cache.mkdir(parents=True, exist_ok=True)
        self.write_scenes()

    def write_scenes(self):
        sources = [ROOT / "bench" / name for name in ("volumes.cpp", "fractal_shells.cpp", "lattice_noise.cpp", "scenes.cpp")]
        sources += sorted((ROOT / "scenes").glob("*.json"))
        self.sources = digest(*[path.read_bytes() for path in sources], self.options.quick)
        self.folder = self.options.cache / f"scenes-{self.sources}"
        names = self.folder / "names.json"
        if not names.is_file():
            print("Writing the scenes", file=sys.stderr, flush=True)
            written = run_program([self.program, "scenes", self.folder, *(["--quick"] if self.options.quick else [])])
            names.write_text(json.dumps(written.split()))
        self.scenes = json.loads(names.read_text())

    def measure(self, scene, light, strategies):
        """What was measured of each strategy, and what is known of the scene."""
        options = self.options
        what = [scene, light, options.width, options.set]
        reference = self.options.cache / f"{scene}-{light}-{digest(what, self.sources, options.reference_samples)}.exr"
        if options.fresh:
            reference.unlink(missing_ok=True)
        kept = {name: options.cache / f"{scene}-{light}-{name}-{digest(what, self.sources, self.build, settings, options.samples, options.seeds, reference.name, options.isa)}.json"
                for name, settings in strategies.items()}
        missing = [name for name in strategies if options.fresh or not kept[name].is_file()]
        if missing:
            print(f"{scene} under {light}: {', '.join(missing)}", file=sys.stderr, flush=True)
            result = json.loads(run_program(
                [self.program, "measure", self.folder / f"{scene}.json", "--light", light if light == BEHIND else light_file(light),
                 "--reference", reference, "--reference-samples", options.reference_samples, "--isa", options.isa,
                 *[a for setting in REFERENCE for a in ("--reference-set", setting)], *set_arguments(options.set),
                 "--width", options.width, "--samples", ",".join(map(str, options.samples)), "--seeds", options.seeds,
                 *[a for name in missing if name != SCALAR for a in ("--variant", f"{name}:{','.join(strategies[name])}")],
                 *(["--scalar"] if SCALAR in missing else [])]))
            estimators = result.pop("estimators")
            for name in missing:
                # Under the final name only when whole.
                partial = kept[name].with_suffix(".partial")
                partial.write_text(json.dumps({**result, **estimators[name]}))
                partial.rename(kept[name])
        return {name: json.loads(path.read_text()) for name, path in kept.items()}


def without_paths(arguments):
    """The options that change what is measured, for the report."""
    kept, skip = [], False
    for argument in arguments:
        if not skip and argument not in ("--program", "--cache", "--output"):
            kept.append(argument)
        skip = argument in ("--program", "--cache", "--output")
    return kept


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small volumes and images, three scenes, one light")
    parser.add_argument("--scenes", nargs="+", default=None, help=" ".join(SCENES))
    parser.add_argument("--lights", nargs="+", default=None, help=f"{' '.join(LIGHTS)} {BEHIND}")
    parser.add_argument("--strategies", nargs="+", default=None, help=" ".join(STRATEGIES))
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="scene entry to change for all; repeatable")
    parser.add_argument("--width", type=int, default=None, help="pixels along each side (112)")
    parser.add_argument("--samples", type=int, nargs="+", default=None, help="sample counts at which errors are taken (16 64)")
    parser.add_argument("--seeds", type=int, default=None, help="images per strategy (2)")
    parser.add_argument("--reference-samples", type=int, default=None, help="(512)")
    parser.add_argument("--isa", default="auto", help="instruction set")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "lumisweep_efficiency")
    parser.add_argument("--output", type=Path, default=None, help="folder of the report (docs/results, or out for less than all)")
    parser.add_argument("--cache", type=Path, default=ROOT / "out" / "efficiency", help="folder of single runs and references")
    parser.add_argument("--fresh", action="store_true", help="measure all again, with new references")
    options = parser.parse_args()
    quick = options.quick
    partial = quick or options.scenes or options.lights or options.strategies or options.set
    options.scenes = options.scenes or (["ct_head", "plume", "shells_400"] if quick else SCENES)
    options.all_lights = options.lights is None
    options.lights = options.lights or (["sunrise"] if quick else LIGHTS)
    unknown = set(options.strategies or []) - set(STRATEGIES)
    if unknown:
        parser.error(f"no strategy {', '.join(sorted(unknown))}; there are {', '.join(STRATEGIES)}")
    options.strategies = list(dict.fromkeys(["environment", *(options.strategies or STRATEGIES)]))
    options.width = options.width or (64 if quick else 112)
    options.samples = sorted(options.samples or ([4, 16] if quick else [16, 64]))
    options.seeds = options.seeds or 2
    options.reference_samples = options.reference_samples or (256 if quick else 512)
    options.output = options.output or ROOT / ("out" if partial else "docs/results")
    options.command = " ".join(["studies/efficiency.py", *without_paths(sys.argv[1:])])
    return options


def places(options, scenes):
    """Scenes and lights; what has not been fetched is left out."""
    for scene in options.scenes:
        if scene not in scenes:
            print(f"No data of {scene}; run scripts/fetch_data {scene}", file=sys.stderr)
            continue
        lights = options.lights + ([BEHIND] if options.all_lights and scene in SCENES_FROM_BEHIND else [])
        for light in lights:
            if light == BEHIND or light_file(light).is_file():
                yield scene, light
            else:
                print(f"No light {light}; run scripts/fetch_data {light}", file=sys.stderr)


def csv_rows(results):
    for (scene, light), of_place in results.items():
        for name, entry in of_place.items():
            row = {"scene": scene, "light": light, "strategy": name}
            for i, samples in enumerate(entry["sample_counts"]):
                row |= {f"mse_{samples}": entry["mse"][i], f"mse_{samples}_error": entry["mse_error"][i]}
            yield row | {key: entry[key] for key in ("sample_s", "preparation_s", "percentile_9999", "kurtosis", "bias_in_errors",
                                                     "visible_light", "reference_mse", "isa")}


def main():
    options = parse_arguments()
    measurements = Measurements(options)
    strategies = {name: STRATEGIES[name] for name in options.strategies} | {SCALAR: []}
    results = {place: measurements.measure(*place, strategies) for place in places(options, measurements.scenes)}
    if not any(light != BEHIND for _, light in results):
        print("No data: nothing is measured", file=sys.stderr)
        return NO_DATA
    options.output.mkdir(parents=True, exist_ok=True)
    rows = list(csv_rows(results))
    with open(options.output / "efficiency.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()} for row in rows)
    report = efficiency_report.Report(results, options, f"{processor()}, {rows[0]['isa']}, commit {commit()}")
    (options.output / "efficiency.svg").write_text(report.plot())
    (options.output / "efficiency.md").write_text(report.text())
    print(report.summary())
    print(f"Report: {options.output / 'efficiency.md'}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError, KeyError, json.JSONDecodeError) as error:
        print(f"efficiency: {error!r}" if isinstance(error, KeyError) else f"efficiency: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)

#!/usr/bin/python3
"""What rays, filter, cells and directions of the sweep do to the image, and what they cost: docs/results/sweep-settings.md.

Two-step sampling of a CT head and a stent under two lights, at equal samples, with the same random numbers for every setting, so
that ratios are sharper than the errors themselves. Runs are cached in out/sweep-settings. About ten minutes.

    studies/sweep_settings.py [--program build/release/lumisweep] [--samples 64] [--width 128] [--repeats 3]
"""
import argparse
import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from common import (ROOT, Renderer, StudyError, commit, cores, load, markdown_rows, mean_and_error, need_inputs, processor, scene_file,
                    set_arguments, with_error)

SCENES = ["ct_head", "stent"]
LIGHTS = ["courtyard", "sunrise"]
REFERENCE_SEED = 900000


@dataclass(frozen=True)
class Setting:
    rays: int = 256  # as many as both scans have voxels along their longest side
    filter: str = "half-angle"
    cell: int = 4
    directions: int = 8
    oversampling: int = 1

    def arguments(self):
        return [f"visibility.{name}={getattr(self, name)}" for name in ("rays", "filter", "cell", "directions", "oversampling")]


DEFAULT = Setting()
GROUPS = {
    "Rays and filter": [Setting(rays=rays, filter=filter_) for rays in (256, 128, 64) for filter_ in ("none", "half-angle", "full-angle")],
    "Cells and directions": [Setting(cell=cell, directions=n) for cell in (2, 4, 8, 16) for n in (4, 8, 16)],
    "Cells and filter": [Setting(cell=cell, filter=filter_) for cell in (2, 4, 8, 16) for filter_ in ("none", "half-angle", "full-angle")],
    "Oversampling in direction": [DEFAULT, *(Setting(filter=filter_, oversampling=times) for filter_, times in
                                             (("none", 1), ("none", 4), ("none", 16), ("half-angle", 4)))],
}


def all_settings():
    return list(dict.fromkeys([DEFAULT, *(setting for group in GROUPS.values() for setting in group)]))


# --- measuring ------------------------------------------------------------------------------------------------------------

def errors(renderer, scene, light, options):
    """Setting → squared errors at the same seeds, the reference's own variance taken off."""
    reference, _ = renderer.render(scene, light, "two-step", options.reference_samples, REFERENCE_SEED)
    measured = {}
    for setting in all_settings():
        stems = [renderer.render(scene, light, "two-step", options.samples, 1 + repeat, setting.arguments())[0]
                 for repeat in range(options.repeats)]
        measured[setting] = [renderer.compare(stem, reference)["mse"] for stem in stems]
    default, _ = mean_and_error(measured[DEFAULT])
    own = default / (1 / options.samples + 1 / options.reference_samples) / options.reference_samples
    return {setting: [mse - own for mse in values] for setting, values in measured.items()}


def relative(measured, setting):
    """Logarithm of the error over the default's, mean and standard error over seeds: pairs share their random numbers."""
    return mean_and_error([math.log(a / b) for a, b in zip(measured[setting], measured[DEFAULT])])


def cost(renderer, scene, setting, repeats=3):
    """Seconds on one thread, the least of several, and bytes."""
    runs = [json.loads(renderer.call(["sweep", scene_file(scene), "--json", "--threads", 1, *set_arguments(setting.arguments())]))
            for _ in range(repeats)]
    return min(run["seconds"]["sweep"] for run in runs), runs[0]["memory_bytes"]["visibility"]


# --- reporting ------------------------------------------------------------------------------------------------------------

def ratio_text(logarithm, error):
    value = math.exp(logarithm)
    return with_error(value, value * error)


def group_table(settings, measured, costs):
    rows = []
    for setting in settings:
        each = [relative(measured[case], setting) for case in measured]
        mean = sum(value for value, _ in each) / len(each)
        error = math.sqrt(sum(error ** 2 for _, error in each)) / len(each)
        mark = " (default)" if setting == DEFAULT else ""
        overall = "1" if setting == DEFAULT else ratio_text(mean, error)
        filter_ = setting.filter + (f", {setting.oversampling}× directions" if setting.oversampling > 1 else "")
        rows.append([f"{setting.rays}²", filter_, str(setting.cell), f"{setting.directions}²{mark}",
                     *[f"{math.exp(value):.2f}" for value, _ in each], overall,
                     " / ".join(f"{costs[scene, setting][0]:.3f}" for scene in SCENES),
                     " / ".join(f"{costs[scene, setting][1] / 1e6:.1f}" for scene in SCENES)])
    return markdown_rows(["rays", "filter", "cell", "directions", *[f"{scene}, {light}" for scene, light in measured], "geometric mean",
                          "sweep, s", "V, MB"], rows)


def report(options, measured, costs, load_before):
    default_errors = [[f"{scene}, {light}", with_error(*mean_and_error(values[DEFAULT]))] for (scene, light), values in measured.items()]
    text = [f"""# Rays, filter, cells and directions

Squared error of two-step sampling at {options.samples} samples a pixel over that of the default; below 1 is better. {options.width} × {options.width} pixels, background
hidden, {options.repeats} seeds, against a reference of {options.reference_samples} samples whose own variance is taken off. Every setting has the same random numbers, so ratios
are sharper than the errors; ± is the standard error over seeds. Beside them what the sweep costs for CT head / stent: wall-clock
seconds on one thread, the least of three, and the grid's memory. Both scans have 256 voxels along their longest side, so that 256² rays are all there
are. The defaults were chosen on these scenes, too.

Measured on {processor()} ({cores()} cores), commit {commit()}; load average {load_before:.1f} before. Regenerate with `studies/sweep_settings.py`.

""" + markdown_rows(["scene", f"MSE at {options.samples}, default"], default_errors)]
    for name, settings in GROUPS.items():
        text.append(f"## {name}\n\n{group_table(settings, measured, costs)}")
    return "\n\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "build" / "release" / "lumisweep", type=Path)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--reference-samples", type=int, default=4096)
    parser.add_argument("--width", type=int, default=128, help="pixels along each side")
    parser.add_argument("--repeats", type=int, default=3, help="seeds")
    parser.add_argument("--cache", type=Path, default=ROOT / "out" / "sweep-settings")
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "results" / "sweep-settings.md")
    options = parser.parse_args()
    need_inputs(SCENES, LIGHTS)
    renderer = Renderer(options.program, options.cache, options.width)
    load_before = load()
    costs = {}
    for scene in SCENES:
        print(f"{scene}: cost of {len(all_settings())} settings", file=sys.stderr, flush=True)
        costs.update({(scene, setting): cost(renderer, scene, setting) for setting in all_settings()})
    measured = {}
    for scene in SCENES:
        for light in LIGHTS:
            print(f"{scene} under {light}", file=sys.stderr, flush=True)
            measured[scene, light] = errors(renderer, scene, light, options)
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(report(options, measured, costs, load_before))
    print(f"Report: {options.output}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError, KeyError, json.JSONDecodeError) as error:
        print(f"sweep_settings: {error!r}" if isinstance(error, KeyError) else f"sweep_settings: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)

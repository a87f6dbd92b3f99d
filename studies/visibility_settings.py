#!/usr/bin/python3
"""What epsilon and the sweep-space filter do to two-step sampling: variance against environment sampling, at equal samples.

Writes docs/results/visibility-settings.md. The variance is the image's own estimate (`noise` of --stats, squared), so no
reference is needed; a few minutes.

    studies/visibility_settings.py [--program build/release/lumisweep] [--samples 64] [--width 128]
"""
import argparse
import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from common import ROOT, StudyError, geometric_mean, light_file, markdown_rows, need_inputs, need_program, run_program, scene_file

SCENES = ["ct_head", "stent", "ch2"]
LIGHTS = ["courtyard", "studio", "city", "sunrise"]
SETTINGS = [("half-angle", 0.01), ("half-angle", 0.03), ("half-angle", 0.1), ("half-angle", 0.3), ("none", 0.01), ("none", 0.1),
            ("full-angle", 0.1)]


def noise(options, scene, light, arguments):
    with tempfile.TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.json"
        run_program([options.program, "render", scene_file(scene),
                     "--set", f"environment.file={light_file(light)}", "--set", "image.show_environment=false",
                     "--width", options.width, "--height", options.width, "--samples", options.samples,
                     "--stats", stats, "-o", Path(folder) / "image.png", *arguments])
        return json.loads(stats.read_text())["noise"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "build" / "release" / "lumisweep", type=Path)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--width", type=int, default=128)
    options = parser.parse_args()
    head = [f"{kind}, ε = {epsilon}" for kind, epsilon in SETTINGS]
    need_program(options.program)
    need_inputs(SCENES, LIGHTS)
    rows, all_ratios = [], []
    for scene in SCENES:
        for light in LIGHTS:
            baseline = noise(options, scene, light, ["--strategy", "environment"])
            ratios = [(baseline / noise(options, scene, light, ["--strategy", "two-step", "--set", f"visibility.filter={kind}", "--set",
                                                                f"visibility.epsilon={epsilon}"])) ** 2
                      for kind, epsilon in SETTINGS]
            all_ratios.append(ratios)
            rows.append([f"{scene}, {light}", *[f"{ratio:.2f}" for ratio in ratios]])
            print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    rows.append(["geometric mean", *[f"{geometric_mean(column):.2f}" for column in zip(*all_ratios)]])
    table = markdown_rows(["scene", *head], rows)
    (ROOT / "docs" / "results" / "visibility-settings.md").write_text(
        "# Epsilon and the sweep-space filter\n\n"
        "How many times less variance two-step sampling has than environment sampling, at equal samples: above 1 is better.\n"
        f"Estimated from {options.samples} samples of {options.width} × {options.width} pixels; a percent or two is noise.\n"
        "Regenerate with `studies/visibility_settings.py`.\n\n" + table + "\n")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (StudyError, OSError) as error:
        print(f"visibility_settings: {error}", file=sys.stderr)
        sys.exit(1)

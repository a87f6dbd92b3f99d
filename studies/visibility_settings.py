#!/usr/bin/python3
"""What epsilon and the sweep-space filter do to two-step sampling: variance against environment sampling, at equal samples.

Writes docs/results/visibility-settings.md. The variance is the image's own estimate (`noise` of --stats, squared), so no
reference is needed; a few minutes.

    studies/visibility_settings.py [--program build/release/lumisweep] [--samples 64] [--width 128]
"""
import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENES = ["ct_head", "stent", "ch2"]
LIGHTS = ["courtyard", "studio", "city", "sunrise"]
SETTINGS = [("half-angle", 0.01), ("half-angle", 0.03), ("half-angle", 0.1), ("half-angle", 0.3), ("none", 0.01), ("none", 0.1),
            ("full-angle", 0.1)]


def noise(options, scene, light, arguments):
    with tempfile.TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.json"
        subprocess.run([options.program, "render", ROOT / "scenes" / f"{scene}.json",
                        "--set", f"environment.file={ROOT}/data/environments/{light}.exr", "--set", "image.show_environment=false",
                        "--width", str(options.width), "--height", str(options.width), "--samples", str(options.samples),
                        "--stats", stats, "-o", Path(folder) / "image.png", *arguments],
                       check=True, capture_output=True)
        return json.loads(stats.read_text())["noise"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "build" / "release" / "lumisweep", type=Path)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--width", type=int, default=128)
    options = parser.parse_args()
    head = [f"{kind}, ε = {epsilon}" for kind, epsilon in SETTINGS]
    rows, logarithms = [], [0.0] * len(SETTINGS)
    for scene in SCENES:
        for light in LIGHTS:
            baseline = noise(options, scene, light, ["--strategy", "environment"])
            ratios = [(baseline / noise(options, scene, light, ["--set", f"visibility.filter={kind}", "--set",
                                                                f"visibility.epsilon={epsilon}"])) ** 2
                      for kind, epsilon in SETTINGS]
            logarithms = [total + math.log(ratio) for total, ratio in zip(logarithms, ratios)]
            rows.append([f"{scene}, {light}", *[f"{ratio:.2f}" for ratio in ratios]])
            print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    rows.append(["geometric mean", *[f"{math.exp(total / (len(SCENES) * len(LIGHTS))):.2f}" for total in logarithms]])
    table = "\n".join("| " + " | ".join(cells) + " |" for cells in [["scene", *head], ["---"] * (len(head) + 1), *rows])
    (ROOT / "docs" / "results" / "visibility-settings.md").write_text(
        "# Epsilon and the sweep-space filter\n\n"
        "How many times less variance two-step sampling has than environment sampling, at equal samples: above 1 is better.\n"
        f"Estimated from {options.samples} samples of {options.width} × {options.width} pixels; a percent or two is noise.\n"
        "Regenerate with `studies/visibility_settings.py`.\n\n" + table + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""What the studies share: running the program, statistics of a few runs, Markdown tables, naming the machine."""
import hashlib
import json
import math
import os
import platform
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


class StudyError(Exception):
    pass


# --- running the program --------------------------------------------------------------------------------------------------

def need_program(program):
    if not Path(program).is_file():
        raise StudyError(f"no program at {program}; build it (./check) or name it with --program")
    return Path(program)


def need_inputs(scenes, lights):
    for scene in scenes:
        if not scene_file(scene).is_file():
            raise StudyError(f"no scene scenes/{scene}.json")
    for light in lights:
        if not light_file(light).is_file():
            raise StudyError(f"no light data/environments/{light}.exr; run scripts/fetch_data {light}")


def scene_file(scene):
    return ROOT / "scenes" / f"{scene}.json"


def light_file(light):
    return ROOT / "data" / "environments" / f"{light}.exr"


def run_program(arguments):
    """What the program prints; its last line of complaint as a StudyError."""
    result = subprocess.run([*map(str, arguments)], capture_output=True, text=True)
    if result.returncode != 0:
        message = result.stderr.strip().splitlines() or ["no message"]
        raise StudyError(f"{Path(arguments[0]).name} {arguments[1]} failed ({result.returncode}): {message[-1]}")
    return result.stdout


def set_arguments(settings):
    return [argument for setting in settings for argument in ("--set", setting)]


class Renderer:
    """Runs the command-line program, once per distinct command and build."""

    def __init__(self, program, cache, width, settings=()):
        self.program, self.cache, self.width = need_program(program), Path(cache), width
        self.settings = list(settings)
        self.build = hashlib.sha256(self.program.read_bytes()).hexdigest()[:12]
        self.cache.mkdir(parents=True, exist_ok=True)

    def call(self, arguments):
        return run_program([self.program, *arguments])

    def render(self, scene, light, strategy, samples, seed, settings=()):
        """Returns (image without suffix, stats). What another build made is not reused: it may have been wrong."""
        arguments = set_arguments([*self.settings, *settings])
        key = hashlib.sha256(scene_file(scene).read_bytes() + repr((arguments, self.build)).encode()).hexdigest()[:8]
        stem = self.cache / f"{scene}-{light}-{self.width}-{strategy}-{samples}-{seed}-{key}"
        stats = Path(f"{stem}.json")
        if not stats.is_file():
            # The stats appear last, under a name that is not looked for: what is found is whole.
            partial = Path(f"{stem}.partial")
            self.call(["render", scene_file(scene), "--set", f"environment.file={light_file(light)}",
                       "--set", "image.show_environment=false", *arguments, "--width", self.width, "--height", self.width,
                       "--strategy", strategy, "--samples", samples, "--seed", seed, "--stats", partial,
                       "-o", f"{stem}.exr", "-o", f"{stem}.png"])
            partial.rename(stats)
        return stem, json.loads(stats.read_text())

    def compare(self, stem, reference):
        return json.loads(self.call(["compare", f"{stem}.exr", f"{reference}.exr", "--json"]))


# --- statistics -----------------------------------------------------------------------------------------------------------

def mean_and_error(values):
    """Mean and its standard error; the error is NaN for a single value."""
    mean = sum(values) / len(values)
    if len(values) < 2:
        return mean, math.nan
    variance = sum((v - mean) ** 2 for v in values) / (len(values) - 1)
    return mean, math.sqrt(variance / len(values))


def geometric_mean(values):
    return math.exp(sum(math.log(value) for value in values) / len(values))


def divide(a, b):
    return a / b if b > 0 else math.inf


def ratio(a, b):
    value = divide(a[0], b[0])
    error = value * math.hypot(divide(a[1], a[0]), divide(b[1], b[0]))
    return value, error


# --- reports --------------------------------------------------------------------------------------------------------------

def with_error(value, error, digits=3):
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    return text if math.isnan(error) else f"{text} ± {error:.1g}"


def markdown_rows(head, rows):
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [head, ["---"] * len(head), *rows])


# --- the machine ----------------------------------------------------------------------------------------------------------

def processor():
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def cores():
    return len(os.sched_getaffinity(0))


def load():
    """Runnable processes, mean over the last minute."""
    return os.getloadavg()[0]


def commit():
    """The checked-out commit, and whether anything differs from it."""
    try:
        git = ["git", "-C", str(ROOT)]
        name = subprocess.run([*git, "rev-parse", "--short", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()
        changed = subprocess.run([*git, "status", "--porcelain", "--", "src", "bench", "python", "studies"], check=True,
                                 capture_output=True, text=True)
        return name + (" with changes" if changed.stdout.strip() else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"

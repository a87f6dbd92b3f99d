"""What the studies share: running the program, statistics of a few runs, Markdown tables, naming the machine."""
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

"""What the tables of the sweeps' report share: names of volumes and benchmarks, numbers as text."""
from textwrap import wrap

NAMES = {"ct": "CT-like", "smoke": "smoke-like", "ch2better": "ch2better (MR, 301 × 370 × 316)",
         "ct-doubled": "CT-like at twice the voxels a side, 8 bits"}


def sweep_key(subject, rays, cell, filter_, threads=1):
    return ("sweep", subject, f"rays:{rays}", f"cell:{cell}", f"filter:{filter_}", f"threads:{threads}")


def prepare_key(subject, level, layouts="both", threads=1):
    return ("prepare", subject, f"mip:{level}", f"layouts:{layouts}", f"threads:{threads}")


def number(value, digits=3):
    """Three digits, without an exponent."""
    if value >= 10 ** (digits - 1):
        return f"{value:.0f}"
    return f"{value:#.{digits}g}" if value >= 1e-4 or value == 0 else f"{value:.1e}"


def seconds(results, *key, clock="cpu_time"):
    return number(results.seconds(*key, clock=clock)) if results.has(*key) else "–"


def milliseconds(results, *key, clock="cpu_time"):
    return number(1e3 * results.seconds(*key, clock=clock)) if results.has(*key) else "–"


def squared(n):
    return f"{n}²"


def paragraph(*sentences):
    return "\n".join(wrap(" ".join(sentences), 130))


def spread(values, show=number):
    """'a to b', or one where both read the same."""
    low, high = show(min(values)), show(max(values))
    return low if low == high else f"{low} to {high}"


def times(value):
    return f"{value:.2g}×" if value < 9.95 else f"{value:.0f}×"


def brute_force_seconds(results, subject, cell):
    """(seconds for all cells on one core, relative to those that were marched)."""
    key = ("brute_force", subject, f"cell:{cell}", "threads:1")
    run = results.best(*key)
    return results.seconds(*key) * run["cells_total"] / run["cells_marched"], run["cells_marched"] / run["cells_total"], run

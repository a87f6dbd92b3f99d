"""References, squared errors against them, and what a few values say: intervals and slopes."""
import hashlib
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import scenes
from common import mean_and_error
from scenes import lumisweep

REFERENCE_SEED = 900000
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Added to the squared reference in relative errors, as lumisweep.compare has it.
RELATIVE_OFFSET = 0.01


@dataclass(frozen=True)
class Reference:
    radiance: np.ndarray      # float64 [height, width, 3]
    variance: float           # of the reference's mean, mean over pixels and channels
    samples: int
    seed: int
    relative_variance: float  # the same over (radiance² + RELATIVE_OFFSET)
    doubt: float              # standard error of the squared error that it really has, relative to `variance`


# --- references -----------------------------------------------------------------------------------------------------------

def build_digest():
    """What another build made is not reused: it may have been wrong."""
    return hashlib.sha256(Path(lumisweep._core.__file__).read_bytes()).hexdigest()[:12]


def reference(scene, light, width, samples, cache):
    key = hashlib.sha256(scenes.fingerprint(scene) + repr((light, width, samples, build_digest())).encode()).hexdigest()[:10]
    file = Path(cache) / f"reference-{scene}-{light}-{width}-{samples}-{key}.npz"
    if not file.is_file():
        session = scenes.open_session(scene, light, width=width, strategy="auto", seed=REFERENCE_SEED)
        image = session.render(samples=samples)
        file.parent.mkdir(parents=True, exist_ok=True)
        # Under the final name only when whole.
        partial = file.with_suffix(".partial.npz")
        np.savez_compressed(partial, radiance=image.radiance, variance=image.variance)
        partial.rename(file)
    with np.load(file) as kept:
        radiance, variance = kept["radiance"].astype(np.float64), kept["variance"].astype(np.float64)
    # Of normal errors, which the three channels of a pixel share; it is the same for all that is compared with the reference.
    of_pixels = variance.sum(axis=2)
    doubt = float(np.sqrt(2 * (of_pixels ** 2).sum()) / of_pixels.sum()) if of_pixels.any() else 0.0
    return Reference(radiance, float(variance.mean()), samples, REFERENCE_SEED,
                     float((variance / (radiance ** 2 + RELATIVE_OFFSET)).mean()), doubt)


def references(places, width, samples, cache):
    found = {}
    for scene, light in places:
        print(f"{scene} under {light}: reference of {samples} samples", file=sys.stderr, flush=True)
        found[scene, light] = reference(scene, light, width, samples, cache)
    return found


def describe(known):
    """For reports: how references were made and how sure they are."""
    return "; ".join(f"{scene} under {light}, auto, {entry.samples} samples, seed {entry.seed}, "
                     f"own variance {entry.variance:.2g} ± {100 * entry.doubt:.1g} %"
                     for (scene, light), entry in known.items())


# --- errors ---------------------------------------------------------------------------------------------------------------

def radiance_of(image):
    """Of a lumisweep.Image, or of an array as it is."""
    return np.asarray(image.radiance if isinstance(image, lumisweep.Image) else image, dtype=np.float64)


def squared_error(image, reference):
    """Mean over pixels and channels, the reference's own part taken off: unbiased, so that it can fall below 0."""
    return float(((radiance_of(image) - reference.radiance) ** 2).mean()) - reference.variance


def relative_squared_error(image, reference):
    squared = (radiance_of(image) - reference.radiance) ** 2 / (reference.radiance ** 2 + RELATIVE_OFFSET)
    return float(squared.mean()) - reference.relative_variance


def share_of_worst(image, reference, part=0.001):
    """How much of the squared error lies in the worst thousandth of the pixels; fireflies make it large."""
    squared = np.sort(((radiance_of(image) - reference.radiance) ** 2).mean(axis=2), axis=None)
    return float(squared[-max(1, round(part * squared.size)):].sum() / squared.sum())


def error_curve(session, reference, counts, clock=time.process_time):
    """[(samples, squared error, seconds of the passes so far)] of one progressive render, the film read at each count."""
    session.prepare()
    curve, seconds = [], 0.0
    for samples in counts:
        begin = clock()
        image = session.render(samples=samples)
        seconds += clock() - begin
        curve.append((samples, squared_error(image, reference), seconds))
    return curve


def weight_moments(environment, n=8):
    """Second moments of light over density, relative to the squared mean, were there no shadows: what lamps do to a density.

    (uniform directions, directions by the light's averages over n × n texels); 1 for sampling the light as it is.
    """
    light = np.maximum(environment.radiance.astype(np.float64) @ LUMINANCE, 0)
    side = light.shape[0] // n
    coarse = light.reshape(n, side, n, side).mean(axis=(1, 3)).repeat(side, axis=0).repeat(side, axis=1)
    uniform = (light ** 2).mean() / light.mean() ** 2
    return float(uniform), float((light ** 2 / np.maximum(coarse, 1e-30)).mean() / light.mean())


# --- what a few values say ------------------------------------------------------------------------------------------------

def student_probability(t, freedom):
    """P(|T| < t) of Student's distribution (Abramowitz and Stegun, 26.7.3 and 26.7.4)."""
    angle = math.atan(t / math.sqrt(freedom))
    cosine, sine = math.cos(angle), math.sin(angle)
    if freedom % 2 == 0:
        term, total = 1.0, 1.0
        for k in range(1, freedom // 2):
            term *= (2 * k - 1) / (2 * k) * cosine ** 2
            total += term
        return sine * total
    total, term = 0.0, cosine
    for k in range(1, (freedom - 1) // 2 + 1):
        total += term
        term *= 2 * k / (2 * k + 1) * cosine ** 2
    return 2 / math.pi * (angle + sine * total)


def student_quantile(level, freedom):
    """t with P(|T| < t) = level, by bisection."""
    low, high = 0.0, 1e6
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if student_probability(middle, freedom) < level else (low, middle)
    return high


def confidence_interval(values, level=0.95):
    """(low, high) of the mean of independent, roughly normal values; NaN for a single one."""
    mean, error = mean_and_error(values)
    if len(values) < 2:
        return math.nan, math.nan
    reach = student_quantile(level, len(values) - 1) * error
    return mean - reach, mean + reach


def interval_reach(values, level=0.95):
    """Half of the confidence interval's width."""
    low, high = confidence_interval(values, level)
    return (high - low) / 2


def fit_slope(log_n, log_mse, errors):
    """Weighted least squares of log_mse over log_n: (slope, standard error), the points' errors taken as independent."""
    x, y = np.asarray(log_n, dtype=float), np.asarray(log_mse, dtype=float)
    weight = 1 / np.broadcast_to(np.asarray(errors, dtype=float), x.shape) ** 2
    centred = x - (weight * x).sum() / weight.sum()
    spread = (weight * centred ** 2).sum()
    return float((weight * centred * y).sum() / spread), float(1 / math.sqrt(spread))

"""The studies' scenes and lights, and sessions of them through the Python module."""
import sys
from functools import lru_cache
from pathlib import Path

import numpy as np

from common import ROOT, StudyError, light_file, scene_file

BUILT = ROOT / "build" / "release" / "python"

try:
    import lumisweep
except ImportError:
    sys.path.insert(0, str(BUILT))
    try:
        import lumisweep
    except ImportError as missing:
        # Scripts import this before anything could catch an error: one line, no traceback.
        sys.exit(f"{Path(sys.argv[0]).stem}: {StudyError(f'no Python module lumisweep ({missing}); build it: ./check')}")

SCENES = ["ct_head", "stent", "ch2better", "brainsmall", "plume", "cloud"]
LIGHTS = ["sunrise", "interior", "city", "night", "studio", "forest", "sunset", "courtyard"]
PAPERS = ["uniform", "environment", "visibility", "combined", "two-step"]
STRATEGIES = [*PAPERS, "auto"]

# What needs no fetched data.
GENERATED, SKY = "generated", "sky"
QUICK_SCENES = [GENERATED, "plume"]
QUICK_LIGHT = SKY

# Where the papers' figures are made again. Different lights: soft with a sun behind clouds, lamps, a sky after sunset.
FIGURES = [("ct_head", "courtyard"), ("stent", "studio"), ("ch2better", "sunset")]

VOLUMES = {"ct_head": "data/ct_head.nrrd", "stent": "data/stent.nrrd", "ch2better": "data/ch2better.nii.gz",
           "brainsmall": "data/brainsmall.nrrd", "plume": "tests/data/plume_4d_density.nrrd", "cloud": "data/cloud_noise.nrrd"}


def figure_places(quick):
    """Pairs of scene and light, whose data are there."""
    places = [(scene, QUICK_LIGHT) for scene in QUICK_SCENES] if quick else FIGURES
    need([scene for scene, _ in places], [light for _, light in places])
    return places


def need(scenes, lights):
    """A StudyError that says what to fetch."""
    missing = []
    for scene in scenes:
        if scene == GENERATED:
            continue
        if scene not in VOLUMES or not scene_file(scene).is_file():
            raise StudyError(f"no scene {scene}; there are {', '.join(SCENES)}")
        if not (ROOT / VOLUMES[scene]).is_file():
            missing.append(Path(VOLUMES[scene]).name.split(".")[0])
    missing += [light for light in lights if light != SKY and not light_file(light).is_file()]
    if missing:
        raise StudyError(f"no data of {', '.join(missing)}; run scripts/fetch_data {' '.join(missing)}")


def open_session(scene, light, *, width, strategy="two-step", seed=0, visibility=None, threads=0, show_environment=False,
                 **render):
    """A session of width × width pixels; `render` takes what lumisweep.RenderSettings takes besides."""
    volume, transfer_function, camera, environment = parts(scene, light)
    image = lumisweep.ImageSettings(width=width, height=width, show_environment=show_environment)
    settings = lumisweep.RenderSettings(strategy=strategy, seed=seed, **render)
    return lumisweep.Session(volume, transfer_function, environment, camera=camera, image_settings=image,
                             render_settings=settings, visibility_settings=visibility or lumisweep.VisibilitySettings(),
                             threads=threads)


def fingerprint(scene):
    """Bytes that change when the scene does."""
    return Path(__file__).read_bytes() if scene == GENERATED else scene_file(scene).read_bytes()


@lru_cache(maxsize=4)
def parts(scene, light):
    """Volume, transfer function, camera and light; the light is turned as the scene file says."""
    if scene == GENERATED:
        if light != SKY:
            return (*generated(), lumisweep.Environment.load(light_file(light)))
        return (*generated(), lumisweep.Environment.sky())
    overrides = {"environment": {"sky": {}}} if light == SKY else {"environment.file": str(light_file(light))}
    session = lumisweep.Session.load(scene_file(scene), overrides=overrides)
    return session.volume, session.transfer_function, session.camera, session.environment


@lru_cache(maxsize=1)
def generated():
    """A ring around a bowl with a ball in it, their edges hard as scans of bone have them: shadows, and much that is hidden."""
    z, y, x = (np.mgrid[0:48, 0:48, 0:48] - 23.5) / 24
    radius = np.sqrt(x * x + y * y + z * z)
    ring = 0.18 - np.hypot(np.hypot(x, y) - 0.76, z)
    bowl = np.minimum(0.06 - np.abs(radius - 0.48), 0.1 - z)
    ball = 0.24 - radius
    density = np.clip(0.5 + 8 * np.maximum.reduce([ring, bowl, ball]), 0, 1)
    volume = lumisweep.Volume(np.round(255 * density).astype(np.uint8))
    transfer_function = lumisweep.TransferFunction([
        {"value": 100, "extinction": 0.0, "albedo": [0.85, 0.62, 0.45]},
        {"value": 140, "extinction": 1.5, "albedo": [0.95, 0.88, 0.78]},
        {"value": 255, "extinction": 4.0, "albedo": [0.98, 0.96, 0.92]}])
    camera = lumisweep.Camera(position=(50.0, -80.0, 105.0), target=(23.5, 23.5, 21.0), up=(0.0, 0.0, 1.0), vertical_fov_deg=21)
    return volume, transfer_function, camera

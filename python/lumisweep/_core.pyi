"""The compiled module: the library's public API, with NumPy arrays.

Arrays of voxels and cells are indexed [z, y, x]; positions, sizes, spacings and directions are written (x, y, z). World space is
the file's physical space (LPS millimetres for medical formats), +Z up for environments. Directions point towards the light.
Whatever the library refuses is an Error with its message.
"""
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_Path = str | PathLike[str]
_Point = tuple[float, float, float]
_Material = Mapping[str, Any] | tuple[float, float, ArrayLike]
_Strategy = Literal["uniform", "environment", "visibility", "combined", "two-step", "auto"]
_RandomNumbers = Literal["auto", "independent", "stratified"]
_Filter = Literal["none", "half-angle", "full-angle"]
_Isa = Literal["auto", "baseline", "avx2", "avx512"]
_Device = Literal["auto", "cpu", "cuda"]

class Error(RuntimeError):
    """What the library refuses: one line that says what, where, and the mend."""

# --- volumes --------------------------------------------------------------------------------------------------------------

@final
class Volume:
    """A regular grid of scalar voxels, placed in the world."""

    def __init__(self, voxels: ArrayLike, *, spacing: ArrayLike | None = None, origin: ArrayLike | None = None,
                 affine: ArrayLike | None = None, slope: float = 1.0, intercept: float = 0.0, copy: bool | None = None) -> None:
        """From an array [z, y, x]; value = slope · voxel + intercept, in the data's own units.

        spacing and origin (the first voxel's centre) are (x, y, z) in world units and place an axis-aligned grid; `affine`
        (4 × 4) instead maps the index (i, j, k) of a voxel's centre along x, y, z to the world. NIfTI's affines are of RAS
        space: np.diag([-1, -1, 1, 1]) @ affine.

        uint8, uint16, int16 and float32 are kept, other types become the smallest of them that holds every value exactly, or
        float32. copy=None shares the array's memory when its type is one of these, it is C-contiguous and in native byte
        order (the transpose of an [x, y, z] array in Fortran order is), has no infinities, and does not end with a page of
        memory, as kernels read up to 64 bytes further (one array in 64 does). copy=False is an Error where that cannot be,
        copy=True always copies. A shared array may be changed between passes if `Session.volume` is set again afterwards.
        NaN is empty space.
        """
    @staticmethod
    def load(files: _Path | Sequence[_Path], *, frame: int = 0) -> Volume:
        """NRRD, MetaImage, NIfTI, a DICOM folder, or several files: a time series, of which `frame` is read."""
    @property
    def shape(self) -> tuple[int, int, int]:
        """(z, y, x) voxels."""
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def voxels(self) -> NDArray[Any]:
        """[z, y, x], read-only, not copied."""
    @property
    def shared(self) -> bool:
        """Whether the voxels are the caller's array."""
    @property
    def affine(self) -> NDArray[np.float64]:
        """4 × 4: index (i, j, k) of a voxel's centre to the world."""
    @property
    def spacing(self) -> _Point:
        """World units, (x, y, z)."""
    @property
    def slope(self) -> float: ...
    @property
    def intercept(self) -> float: ...
    @property
    def modality(self) -> str:
        """DICOM's code ("CT", "MR") or empty."""
    @property
    def warnings(self) -> list[str]:
        """What reading or converting met, one line each."""
    def interpolate(self, positions: ArrayLike) -> NDArray[np.float64]:
        """Trilinear values in data units at world positions [..., 3]; NaN where a NaN voxel takes part, edge voxels outside."""

def inspect_volume(file: _Path) -> dict[str, Any]:
    """What a file's header says (format, size, spacing, frames, …); no voxel is read."""

# --- transfer functions and light -----------------------------------------------------------------------------------------

@final
class TransferFunction:
    """Value in data units to extinction (1 / world unit) and albedo, piecewise linear, clamped outside."""

    def __init__(self, points: Iterable[_Material], *, extinction_scale: float = 1.0) -> None:
        """By value; {"value": v, "extinction": e, "albedo": [r, g, b]} as in a scene file (white by default), or tuples."""
    @staticmethod
    def preset(name: str, volume: Volume, *, extinction_scale: float = 1.0) -> TransferFunction:
        """By name (`preset_names()`), fitted to the volume's values; "auto" chooses the preset from the data."""
    @property
    def points(self) -> list[tuple[float, float, _Point]]:
        """(value, extinction before extinction_scale, albedo)."""
    @property
    def extinction_scale(self) -> float: ...
    def __call__(self, values: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(extinction [...], albedo [..., 3]) of values [...]; NaN is empty."""

def preset_names() -> list[str]: ...

@final
class Environment:
    """Radiance from all directions, as an equal-area octahedral map; +Z is up."""

    @staticmethod
    def load(file: _Path, *, scale: float = 1.0, rotation_deg: float = 0.0) -> Environment:
        """A latitude-longitude map, OpenEXR or Radiance HDR."""
    @staticmethod
    def from_latlong(radiance: ArrayLike, *, scale: float = 1.0, rotation_deg: float = 0.0) -> Environment:
        """[height, width, 3]: row 0 is +Z, the centre column looks along +X, columns run clockwise seen from above."""
    @staticmethod
    def from_octahedral(radiance: ArrayLike) -> Environment:
        """[n, n, 3], n a power of two, row v and column u as `octahedral_directions(n)`."""
    @staticmethod
    def constant(radiance: ArrayLike = ...) -> Environment: ...
    @staticmethod
    def sky(*, zenith: ArrayLike = ..., horizon: ArrayLike = ..., ground: ArrayLike = ..., sun_direction: ArrayLike = ...,
            sun_angular_diameter_deg: float = ..., sun_irradiance: ArrayLike = ..., resolution: int = 512) -> Environment:
        """The scene file's analytic sky, with its names and defaults."""
    @property
    def resolution(self) -> int:
        """n of the n × n map."""
    @property
    def radiance(self) -> NDArray[np.float32]:
        """[n, n, 3], a copy."""
    @property
    def mean_luminance(self) -> float: ...
    @property
    def warnings(self) -> list[str]: ...
    def __call__(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Radiance [..., 3] from directions [..., 3], constant over a texel."""

def octahedral_directions(n: int) -> NDArray[np.float64]:
    """[n, n, 3]: unit directions of the texels' centres, row v, column u. Every texel covers 4π / n² sr."""

# --- settings -------------------------------------------------------------------------------------------------------------
# The scene file's names and defaults, keyword-only. They do not change; `replace` gives a changed copy.

@final
class Camera:
    def __init__(self, *, position: ArrayLike = ..., target: ArrayLike = ..., up: ArrayLike = ..., vertical_fov_deg: float = 35.0,
                 lens_radius: float = 0.0, focus_distance: float | None = None) -> None:
        """Lengths in world units; focus_distance None is the target's distance."""
    @staticmethod
    def framed(volume: Volume, transfer_function: TransferFunction, *, width: int = 512, height: int = 512,
               vertical_fov_deg: float = 35.0) -> Camera:
        """In front of what the transfer function shows, at the distance at which it just fits."""
    @property
    def position(self) -> _Point: ...
    @property
    def target(self) -> _Point: ...
    @property
    def up(self) -> _Point: ...
    @property
    def vertical_fov_deg(self) -> float: ...
    @property
    def lens_radius(self) -> float: ...
    @property
    def focus_distance(self) -> float | None: ...
    def camera_from_world(self) -> NDArray[np.float64]:
        """4 × 4, for column vectors: x to the right, y up, z along the view."""
    def replace(self, **entries: Any) -> Camera: ...

@final
class ImageSettings:
    def __init__(self, *, width: int = 512, height: int = 512, show_environment: bool = True) -> None: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def show_environment(self) -> bool: ...
    def replace(self, **entries: Any) -> ImageSettings: ...

@final
class RenderSettings:
    def __init__(self, *, strategy: _Strategy = "auto", random_numbers: _RandomNumbers = "auto",
                 shadow_rays: int | Literal["auto"] = "auto", seed: int = 0) -> None: ...
    @property
    def strategy(self) -> _Strategy: ...
    @property
    def random_numbers(self) -> _RandomNumbers: ...
    @property
    def shadow_rays(self) -> int | Literal["auto"]: ...
    @property
    def seed(self) -> int: ...
    def replace(self, **entries: Any) -> RenderSettings: ...

@final
class VisibilitySettings:
    def __init__(self, *, directions: int = 8, cell: int = 4, rays: int | Literal["auto"] = "auto",
                 filter: _Filter = "half-angle", oversampling: int = 1, epsilon: float = 0.1) -> None: ...
    @property
    def directions(self) -> int: ...
    @property
    def cell(self) -> int: ...
    @property
    def rays(self) -> int | Literal["auto"]: ...
    @property
    def filter(self) -> _Filter: ...
    @property
    def oversampling(self) -> int: ...
    @property
    def epsilon(self) -> float: ...
    def replace(self, **entries: Any) -> VisibilitySettings: ...

# --- rendering ------------------------------------------------------------------------------------------------------------

@final
class Session:
    """A progressive render: volume → majorants, sweeps → film.

    Set attributes between passes; only what depends on them is redone.

    render, prepare and sweeps let other Python threads run and end at Ctrl-C with KeyboardInterrupt, with the passes so far in
    the film. Meanwhile the session refuses other calls; a progress callback may read film, settings and stats.
    """

    def __init__(self, volume: Volume, transfer_function: TransferFunction | None = None,
                 environment: Environment | None = None, *, camera: Camera | None = None,
                 image_settings: ImageSettings = ..., render_settings: RenderSettings = ...,
                 visibility_settings: VisibilitySettings = ..., threads: int = 0, isa: _Isa = "auto",
                 device: _Device = "cpu") -> None:
        """What is None is chosen as for the command line: a preset, the sky, a camera that frames the volume.

        device "auto": a GPU if there is one, else the CPU, which notes says.

        threads 0: all that the machine has, which is also the most.
        """
    @staticmethod
    def load(scene: _Path | Mapping[str, Any], *, overrides: Mapping[str, Any] = ..., base_directory: _Path = ...,
             threads: int = 0, isa: _Isa = "auto", device: _Device = "cpu") -> Session:
        """From a scene file, or a dictionary with a scene file's entries; overrides {"visibility.cell": 8} are put in before.

        Paths are relative to the file, or to base_directory (the current one).
        """
    @property
    def notes(self) -> list[str]:
        """What was chosen where the scene left it open."""
    @property
    def warnings(self) -> list[str]:
        """What the data made necessary."""
    volume: Volume
    transfer_function: TransferFunction
    environment: Environment
    camera: Camera
    image_settings: ImageSettings
    render_settings: RenderSettings
    visibility_settings: VisibilitySettings
    @property
    def samples(self) -> int:
        """A pixel, in the film."""
    @property
    def noise(self) -> float:
        """Estimated relative error of the image; infinite while unknown."""
    @property
    def device(self) -> str: ...
    @property
    def isa(self) -> str: ...
    @property
    def threads(self) -> int: ...
    @property
    def stats(self) -> dict[str, Any]:
        """As --stats of the command line: "seconds" by stage, "memory_bytes", "paths", "shadow_rays", "steps"."""
    def prefetch(self, volume: Volume) -> None:
        """The volume that will be set next, as of a time series: a GPU begins to copy it while passes go on."""
    def prepare(self) -> None:
        """Majorants, sweeps, joint grid: what the next pass would begin with."""
    def render(self, *, samples: int | None = None, time: float | None = None, noise: float | None = None,
               progress: Callable[[int, float], object] | None = None) -> Image:
        """Adds passes until the film has `samples` a pixel, `time` seconds have passed or the relative error is `noise`.

        Without any of them, what the scene says (64 samples). progress(samples, seconds) is called after passes, at most ten
        times a second.
        """
    def image(self) -> Image:
        """The film as it is; an Error before the first pass."""
    def sweep_in_background(self, threads: int = 0) -> None:
        """Edits do not wait for sweeps from now on; passes go on with the visibility that is there.

        threads 0: half of the machine's.
        """
    def sweep_before_pass(self) -> None:
        """The default: the next pass waits, and images repeat to the bit."""
    @property
    def sweeping(self) -> bool: ...
    @property
    def visibility(self) -> VisibilityGrid:
        """A copy of the visibility grid that directions are drawn by, after prepare()."""
    @visibility.setter
    def visibility(self, grid: VisibilityGrid) -> None: ...
    def sampler(self, strategy: _Strategy | None = None) -> DirectionSampler:
        """How directions are drawn with this session's light and visibility; another strategy than its own if given."""

# --- visibility -----------------------------------------------------------------------------------------------------------

@final
class VisibilityGrid:
    """V [v, u, z, y, x] of 8 bits: row v and column u of the octahedral map, then the cell."""

    def __init__(self, values: ArrayLike, volume: Volume, *, cell: int) -> None:
        """values: uint8 (255 is visible) or floating point in [0, 1], of the shape that such cells have."""
    @property
    def values(self) -> NDArray[np.uint8]:
        """[n, n, cells z, cells y, cells x], a copy; V = values / 255."""
    @property
    def cells(self) -> tuple[int, int, int]:
        """(x, y, z)."""
    @property
    def directions(self) -> int:
        """n of the n × n directions."""
    @property
    def stats(self) -> dict[str, Any]:
        """Of the sweep that made it: seconds, processor_seconds by part, voxel_steps, rays, mip_level; else empty."""

def sweep_visibility(volume: Volume, transfer_function: TransferFunction, settings: VisibilitySettings = ..., *,
                     threads: int = 0) -> VisibilityGrid:
    """Journal paper, sections 6 and 8."""

def brute_force_visibility(volume: Volume, transfer_function: TransferFunction, settings: VisibilitySettings = ..., *,
                           reference: Literal["classified", "exact"] = "classified", step_voxels: float = 0.5,
                           threads: int = 0) -> VisibilityGrid:
    """One ray for every cell and direction, in double precision, rounded to 8 bits: slow. `transmittance` has the references."""

def transmittance(volume: Volume, transfer_function: TransferFunction, positions: ArrayLike, directions: ArrayLike, *,
                  reference: Literal["classified", "exact"] = "exact", step_voxels: float = 0.5,
                  threads: int = 0) -> NDArray[np.float64]:
    """From world positions [..., 3] along unit directions [..., 3] (broadcast) to the outside, in double precision.

    "exact": the renderer's volume, interpolated and then classified, by midpoint steps of `step_voxels`. "classified": the
    sweeps' volume, classified to 8 bits and then interpolated, integrated exactly. 1 from positions outside of the volume.
    """

def cell_centres(volume: Volume, *, cell: int = 4) -> NDArray[np.float64]:
    """[z, y, x, 3]: where in the world a visibility grid's values are meant."""

@final
class DirectionSampler:
    """A strategy's density of directions, at any point."""

    def __init__(self, strategy: _Strategy, volume: Volume, environment: Environment, visibility: VisibilityGrid | None = None, *,
                 epsilon: float = 0.1) -> None:
        """uniform and environment need no visibility. "auto" has two-step's density."""
    @property
    def strategy(self) -> str: ...
    def pdf(self, positions: ArrayLike, directions: ArrayLike) -> NDArray[np.float64]:
        """Per steradian, of directions [..., 3] at world positions [..., 3] (broadcast)."""
    def pdf_map(self, position: ArrayLike, n: int | None = None) -> NDArray[np.float64]:
        """[n, n] per steradian at one world position, at the texels' centres; n defaults to the environment's resolution."""
    def sample(self, position: ArrayLike, numbers: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(directions [..., 3], pdf per steradian [...]) of numbers [..., 3] in [0, 1) at one world position."""

# --- images ---------------------------------------------------------------------------------------------------------------

@final
class Image:
    """Float channels by name, row 0 at the top, with the attributes of an EXR header."""

    def __init__(self, channels: Mapping[str, ArrayLike]) -> None:
        """{"R": [height, width], …}."""
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def channels(self) -> list[str]: ...
    @property
    def attributes(self) -> dict[str, Any]: ...
    def __getitem__(self, channel: str) -> NDArray[np.float32]:
        """[height, width]; KeyError where there is none of that name."""
    def __contains__(self, channel: object) -> bool: ...
    @property
    def radiance(self) -> NDArray[np.float32]:
        """[height, width, 3], linear."""
    @property
    def alpha(self) -> NDArray[np.float32]:
        """[height, width]: 1 − mean transmittance along the camera ray."""
    @property
    def variance(self) -> NDArray[np.float32]:
        """[height, width, 3], of the pixel's mean."""
    @property
    def albedo(self) -> NDArray[np.float32]: ...
    @property
    def normal(self) -> NDArray[np.float32]: ...
    @property
    def depth(self) -> NDArray[np.float32]:
        """[height, width]: distance of the first collision along the camera ray, mean over samples."""
    def write_exr(self, file: _Path) -> None: ...
    def tone_map(self, *, exposure: float | None = None, show_environment: bool | None = None) -> NDArray[np.uint8]:
        """[height, width, 3 or 4], sRGB, as the command line's PNG; show_environment False: nothing behind, with alpha."""
    def write_png(self, file: _Path, *, exposure: float | None = None, show_environment: bool | None = None) -> None: ...

def read_exr(file: _Path) -> Image: ...

def compare(image: Image, reference: Image) -> dict[str, float]:
    """mse, relmse (ε = 0.01), rmse, psnr, mean_image, mean_reference, over all pixels and R, G, B."""

def available_isas() -> list[str]:
    """Instruction sets that this build has and this machine runs, best first."""

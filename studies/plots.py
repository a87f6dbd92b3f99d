"""How the studies look: plots and pictures for a paper, the options they share, and what their reports begin with."""
import csv
import io
import sys
import textwrap
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image as PillowImage

from common import ROOT, StudyError, commit, cores, load, processor
from measure import LUMINANCE
from scenes import lumisweep

# The papers' colours.
COLOURS = {"uniform": "#d62728", "environment": "#d4a000", "visibility": "#2ca02c", "combined": "#17a9c8", "two-step": "#c724b1",
           "auto": "#222222"}
LABELS = {name: name.capitalize() for name in COLOURS}

PNG_BYTES, SVG_BYTES = 400_000, 300_000
DPI = 100

plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 8, "axes.titlesize": 9, "axes.labelsize": 8, "legend.fontsize": 7,
    "xtick.labelsize": 7, "ytick.labelsize": 7, "lines.linewidth": 1.2, "axes.linewidth": 0.6, "axes.grid": True,
    "axes.axisbelow": True, "grid.color": "#dddddd", "grid.linewidth": 0.5, "axes.spines.top": False, "axes.spines.right": False,
    "legend.frameon": False, "figure.dpi": DPI, "savefig.dpi": DPI, "svg.hashsalt": "lumisweep", "svg.fonttype": "none"})


# --- files ----------------------------------------------------------------------------------------------------------------

def save(figure, path):
    """PNG or SVG by the name. A PNG that is too large for a repository gets a palette, of 256 colours or fewer."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".svg":
        # No date, so that the same numbers give the same file.
        figure.savefig(path, metadata={"Date": None})
        limit = SVG_BYTES
    else:
        figure.canvas.draw()
        picture = PillowImage.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
        data = png_bytes(picture)
        for colours in (256, 128, 64):
            if len(data) > PNG_BYTES:
                data = png_bytes(picture.quantize(colours, dither=PillowImage.Dither.NONE))
        path.write_bytes(data)
        limit = PNG_BYTES
    plt.close(figure)
    if path.stat().st_size > limit:
        print(f"{path} has {path.stat().st_size} bytes, more than {limit}", file=sys.stderr)


def png_bytes(picture):
    packed = io.BytesIO()
    picture.save(packed, "PNG", optimize=True)
    return packed.getvalue()


# --- pictures -------------------------------------------------------------------------------------------------------------

def display(images, reference=None):
    """Radiance arrays of one shape as 8-bit sRGB, with the exposure and the white that suit the reference, else the first."""
    reference = images[0] if reference is None else reference
    brightness = np.asarray(reference, dtype=np.float64) @ LUMINANCE
    lit = brightness[brightness > 0]
    exposure = 0.25 / np.exp(np.log(lit).mean()) if lit.size else 1.0
    # Tone mapping takes its white from the image: in one stack, with fireflies held at the reference's white, it is one for all.
    white = max(np.percentile(brightness, 99.9), 1 / exposure)
    stack = np.concatenate([np.asarray(image, dtype=np.float64) for image in (reference, *images)])
    bright = stack @ LUMINANCE
    stack = stack * np.minimum(1, white / np.maximum(bright, 1e-30))[..., None]
    channels = {name: np.ascontiguousarray(stack[..., c], dtype=np.float32) for c, name in enumerate("RGB")}
    shown = lumisweep.Image(channels).tone_map(exposure=float(exposure))[..., :3]
    return np.split(shown, len(images) + 1)[1:]


def latlong(environment, height=64):
    """The light as it is all around, [height, 2 · height, 3] radiance, +Z on top."""
    polar = np.pi * (np.arange(height) + 0.5) / height
    azimuth = np.pi * (1 - (np.arange(2 * height) + 0.5) / height)
    polar, azimuth = np.meshgrid(polar, azimuth, indexing="ij")
    return environment(np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1))


def window_means(values, side):
    sums = np.pad(values.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    return (sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]) / side ** 2


def largest(score):
    return tuple(int(i) for i in np.unravel_index(np.argmax(score), score.shape))


def noisiest_window(image, reference, side):
    """(y, x) of the side × side window where an image differs most from the reference, relative to its brightness there."""
    bright = window_means((reference ** 2).mean(axis=2), side)
    return largest(window_means(((image - reference) ** 2).mean(axis=2), side) / (bright + bright.mean()))


def telling_window(reference, side):
    """(y, x) of the side × side window with the most light and shadow among those that the volume fills."""
    brightness = np.sqrt(np.maximum(reference @ LUMINANCE, 0))
    filled, mean = window_means((brightness > 0).astype(float), side), window_means(brightness, side)
    spread = np.maximum(window_means(brightness ** 2, side) - mean ** 2, 0)
    return largest(np.where(filled >= 0.95 * filled.max(), spread, -1))


class Canvas:
    """A figure laid out in pixels, so that magnified windows keep whole pixels; (0, 0) is at the top left."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.figure = plt.figure(figsize=(width / DPI, height / DPI), facecolor="white")

    def image(self, pixels, left, top, size, frame=None):
        """An 8-bit image [height, width, 3] at `size` (width, height), nearest pixels; a coloured frame if one is given."""
        width, height = size
        axes = self.figure.add_axes([left / self.width, 1 - (top + height) / self.height,
                                     width / self.width, height / self.height])
        rows, columns = np.arange(height) * pixels.shape[0] // height, np.arange(width) * pixels.shape[1] // width
        axes.imshow(pixels[rows][:, columns], interpolation="nearest", aspect="auto")
        axes.set_axis_off()
        if frame:
            axes.add_patch(plt.Rectangle((0, 0), 1, 1, transform=axes.transAxes, fill=False, edgecolor=frame, linewidth=3))
        return axes

    def inset(self, pixels, corner, side, left, top, size, frame):
        """The side × side window at corner (y, x), magnified to size × size."""
        y, x = corner
        return self.image(pixels[y:y + side, x:x + side], left, top, (size, size), frame)

    def text(self, text, left, top, **style):
        self.figure.text(left / self.width, 1 - top / self.height, text, **{"va": "top", "ha": "left", "fontsize": 7, **style})


def mark_window(axes, corner, side, scale, colour="#ff9900"):
    """Where the insets come from, in an image that is shown `scale` times as large."""
    y, x = corner
    axes.add_patch(plt.Rectangle((x * scale - 0.5, y * scale - 0.5), side * scale, side * scale, fill=False, edgecolor=colour,
                                 linewidth=1))


REFERENCE_SIZE, INSET_SIZE, WINDOW, GAP, TITLE, CAPTION = 256, 208, 52, 8, 18, 32


def strategy_rows(rows):
    """The papers' comparison: for each place the reference and the same magnified window of every strategy's image.

    rows: (title, reference, {strategy: (image, caption)}), radiance arrays of one size; two lines of caption below each inset.
    """
    names = list(rows[0][2])
    row_height = 2 * TITLE + INSET_SIZE + CAPTION + GAP
    canvas = Canvas(GAP + REFERENCE_SIZE + (GAP + INSET_SIZE) * len(names) + GAP, row_height * len(rows))
    for index, (title, reference, entries) in enumerate(rows):
        top = index * row_height + TITLE
        shown = dict(zip(names, display([entries[name][0] for name in names], reference)))
        corner = telling_window(reference, WINDOW)
        canvas.text(title, GAP, top - 16, fontsize=9)
        axes = canvas.image(display([reference])[0], GAP, top, (REFERENCE_SIZE, REFERENCE_SIZE))
        mark_window(axes, corner, WINDOW, REFERENCE_SIZE / reference.shape[0])
        for column, name in enumerate(names):
            left = GAP + REFERENCE_SIZE + GAP + column * (INSET_SIZE + GAP)
            canvas.inset(shown[name], corner, WINDOW, left, top + TITLE, INSET_SIZE, COLOURS[name])
            canvas.text(LABELS[name], left, top, fontsize=9, color=COLOURS[name], weight="bold")
            canvas.text(entries[name][1], left, top + TITLE + INSET_SIZE + 6, linespacing=1.4)
    return canvas.figure


# --- options and reports --------------------------------------------------------------------------------------------------

def standard_options(parser):
    parser.add_argument("--quick", action="store_true", help="small, in some seconds, without fetched data, into out/studies")
    parser.add_argument("--output", type=Path, default=None, metavar="DIR", help="for the report (docs/results)")
    parser.add_argument("--cache", type=Path, default=ROOT / "out" / "studies" / "cache", metavar="DIR", help="for references")


def parse(parser):
    """The options; `output` is a folder that exists."""
    standard_options(parser)
    options = parser.parse_args()
    options.output = options.output or ROOT / ("out/studies" if options.quick else "docs/results")
    options.output.mkdir(parents=True, exist_ok=True)
    options.started, options.load_before, options.commit = time.time(), load(), commit()
    return options


def prose(text, bullet=""):
    """Paragraphs whose line breaks in the source do not matter, as one list item each if there is a bullet ("- ", "  - ")."""
    def fill(paragraph):
        return textwrap.fill(" ".join(paragraph.split()), 130, initial_indent=bullet, subsequent_indent=" " * len(bullet),
                             break_long_words=False, break_on_hyphens=False)

    return ("\n" if bullet else "\n\n").join(fill(paragraph) for paragraph in text.strip().split("\n\n"))


def slashed(values):
    return " / ".join(f"{value:.2f}" for value in values)


def write_csv(path, rows):
    """Rows are dictionaries of the same keys."""
    with open(path, "w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]))
        writer.writeheader()
        for row in rows:
            writer.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})


def progress(line):
    print(line, file=sys.stderr, flush=True)


def header(study, options, seeds, reference=None):
    """Where, when and with which numbers a study was made, and how to make it again."""
    known = f" References: {reference}." if reference else ""
    minutes = (time.time() - options.started) / 60
    return prose(f"""Measured on {processor()}, {cores()} cores, {lumisweep.available_isas()[0]}, commit {options.commit},
        {time.strftime('%Y-%m-%d', time.gmtime())}, {minutes:.1f} minutes; load average {options.load_before:.1f} before.
        {seeds}{known} Regenerate with `studies/{study}.py{' --quick' if options.quick else ''}`.""")


def run(main):
    """Ends the program with main's answer; what a study or the library refuses is one line."""
    name = Path(sys.argv[0]).stem
    try:
        sys.exit(main())
    except (StudyError, lumisweep.Error, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)

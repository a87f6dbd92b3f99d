"""The text and the plot of studies/efficiency.py."""
import math
from html import escape

from common import divide, geometric_mean, markdown_rows, ratio

BASELINE, YARDSTICK = "environment", "scalar"
DEFAULTS = ["auto", "two-step"]  # the program's default is the first that was measured
HIDDEN = 0.1                     # light is mostly hidden where less than this share of it arrives
# "With preparation" is for a picture of this many pixels and samples a pixel, on one core.
PICTURE_PIXELS, PICTURE_SAMPLES = 512 * 512, 256

PREFACE = """# Noise by processor time

**Efficiency** is one over (mean squared error × processor time), at {samples} samples a pixel, mean over the pixels and channels of
{width} × {width} images whose background is hidden. Ratios of it: how many times less time for the same error. Times are those of one
thread, the mean over the faster half of a seed's passes, the least of seeds. The error is that against a reference of {reference} samples a pixel, less the
reference's own, which half of the squared difference of its two halves tells; mean over {seeds} seeds.

- **(a)** is environment sampling in the same renderer, **(b)** the plain scalar tracker of `bench/scalar_tracker.h`: single paths, delta
  tracking through majorants of 4³ voxels, environment sampling from distribution tables, ratio tracking.
- **with preparation**: for a picture of 512² pixels and 256 samples, on one core, with all that comes before (majorants;
  classification, sweeps, joint grid).
- **light that arrives**: the mean of the image over the mean of albedo × mean radiance, which it would be without shadows.
- **p99.99** and **kurtosis** are of single samples over the reference's pixel (luminance), where the volume covers half of the pixel and
  the reference is no darker than a twentieth of the mean. The higher, the more fireflies. A sample of `auto`, and of `environment,
  stratified`, is the mean over three shadow rays.
- The papers' five, `environment` among them, take independent numbers and one shadow ray. **environment, stratified** has the numbers and
  the three collisions of `auto`: what is between the two is visibility's part.

Scenes: real data (`ct_head`, `stent`, `ch2better`), a simulated plume, generated volumes of `bench/volumes.h` (512 × 512 × 460 CT-like,
384 × 384 × 512 smoke-like, 384³ fractal shells of mean optical depth 2 and 400). Light `behind` is a sky with a bright sun of 10° exactly behind what
is looked at.

Measured on {machine}. Regenerate with `{command}`. Of {count} means by (a), (b) and {default}, the one that
differs most from its reference does so by {bias:.1f} standard errors; the heavy tails of the others leave no such test. All numbers: [efficiency.csv](efficiency.csv).
"""


def number(value):
    return f"{value:.2g}" if value < 0.1 else f"{value:.2f}" if value < 99.5 else f"{value:.0f}"


def short(value):
    return f"{value:.2g}" if value < 10 else f"{value:.0f}"


def error_rate(entry):
    """Mean squared error × time of a sample, at the largest count."""
    return entry["mse"][-1] * entry["sample_s"]


def gain(baseline, entry):
    return divide(error_rate(baseline), error_rate(entry))


class Report:
    def __init__(self, results, options, machine):
        self.results, self.options, self.machine = results, options, machine
        self.names = options.strategies
        self.default = next((name for name in DEFAULTS if name in self.names), self.names[-1])

    def picture_s(self, entry):
        return entry["preparation_s"] + entry["sample_s"] * PICTURE_SAMPLES * PICTURE_PIXELS / self.options.width ** 2

    def gain_prepared(self, baseline, entry):
        return divide(baseline["mse"][-1] * self.picture_s(baseline), entry["mse"][-1] * self.picture_s(entry))

    def gains(self, name, baseline, prepared=False):
        of_pair = self.gain_prepared if prepared else gain
        return {place: of_pair(entries[baseline], entries[name]) for place, entries in self.results.items()}

    def hidden(self):
        return [place for place, entries in self.results.items() if entries[BASELINE]["visible_light"] < HIDDEN]

    def summary_rows(self):
        for name in self.names:
            to_a, to_b = self.gains(name, BASELINE), self.gains(name, YARDSTICK)
            of_hidden = [to_a[place] for place in self.hidden()]
            worst = min(to_b, key=to_b.get)
            yield [name, number(geometric_mean(to_a.values())), number(min(to_a.values())), number(geometric_mean(to_b.values())),
                   f"{number(to_b[worst])} ({', '.join(worst)})",
                   number(geometric_mean(self.gains(name, BASELINE, True).values())),
                   number(geometric_mean(self.gains(name, YARDSTICK, True).values())),
                   number(geometric_mean(of_hidden)) if of_hidden else "–", self.behind_best(name)]

    def best_other(self, place, name):
        others = {other: error_rate(entry) for other, entry in self.results[place].items() if other not in (name, YARDSTICK)}
        return min(others, key=others.get) if others else name

    def behind_best(self, name):
        """Where it is worst against the best of the others."""
        def against_best(place):
            entries = self.results[place]
            return gain(entries[self.best_other(place, name)], entries[name])
        worst = min(self.results, key=against_best)
        return f"{number(against_best(worst))} ({', '.join(worst)}, {self.best_other(worst, name)})" if len(self.names) > 1 else "–"

    SUMMARY_HEAD = ["strategy", "to (a)", "least to (a)", "to (b)", "least to (b)", "with preparation, to (a)", "to (b)",
                    "to (a), hidden light", "least to the best other"]

    def matrix(self, cell, names, head=(), extra=lambda entries: []):
        return markdown_rows(["scene, light", *head, *names],
                             [[f"{scene}, {light}", *extra(entries), *[cell(entries, name) for name in names]]
                              for (scene, light), entries in self.results.items()])

    def text(self):
        light_tailed = [of_place[name] for of_place in self.results.values() for name in {BASELINE, self.default, YARDSTICK}]
        options = self.options
        arrives = lambda of_place: [f"{of_place[BASELINE]['visible_light']:.3f}"]
        default_error = lambda of_place, name: ratio((of_place[BASELINE]["mse"][-1], of_place[BASELINE]["mse_error"][-1]),
                                                     (of_place[name]["mse"][-1], of_place[name]["mse_error"][-1]))
        both = [*self.names, YARDSTICK]
        return "\n\n".join([
            PREFACE.format(samples=options.samples[-1], width=options.width, reference=options.reference_samples,
                           seeds=options.seeds, machine=self.machine, command=options.command, count=len(light_tailed), default=self.default,
                           bias=max((entry["bias_in_errors"] for entry in light_tailed), key=abs)).rstrip(),
            "## Summary", f"Geometric means over {len(self.results)} scenes and lights. Light is mostly hidden (less than "
            f"{HIDDEN} arrives) in: {'; '.join(', '.join(place) for place in self.hidden()) or 'none of them'}.",
            markdown_rows(self.SUMMARY_HEAD, list(self.summary_rows())),
            "![efficiency by scene](efficiency.svg)",
            "## Efficiency relative to (a)",
            self.matrix(lambda e, name: number(gain(e[BASELINE], e[name])), both, ["light that arrives"], arrives),
            "## Efficiency relative to (b)",
            self.matrix(lambda e, name: number(gain(e[YARDSTICK], e[name])), self.names),
            f"## Error at equal samples relative to (a), {self.default}",
            self.matrix(lambda e, name: "{:.2f} ± {:.2f}".format(*default_error(e, name)), [self.default]),
            "## Fireflies: p99.99, kurtosis",
            self.matrix(lambda e, name: f"{short(e[name]['percentile_9999'])}, {short(e[name]['kurtosis'])}", both),
            "## Times", "Of a sample of every pixel, ms; then preparation, s.",
            self.matrix(lambda e, name: f"{1000 * e[name]['sample_s']:.2f}; {e[name]['preparation_s']:.2f}", both)]) + "\n"

    def summary(self):
        rows = [["strategy", "to (a)", "least", "to (b)", "least"], *[row[:5] for row in self.summary_rows()]]
        widths = [max(len(row[i]) for row in rows) for i in range(5)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)) for row in rows]
        lines.append("Efficiency relative to (a) environment sampling and (b) the scalar tracker, geometric means and least.")
        return "\n".join(lines)

    def plot(self):
        """Efficiency relative to (b), a row for each scene and light, on a logarithmic axis; SVG."""
        colours = ["#888888", "#1f77b4", "#2ca02c", "#9467bd", "#ff7f0e", "#d62728", "#17becf", "#8c564b", "#e377c2", "#bcbd22"]
        low, high, left, width, step, top = -1, 2, 170, 560, 16, 40
        rows = list(self.results.items())
        height = top + step * len(rows) + 44
        x_of = lambda value: left + width * (min(max(math.log10(max(value, 1e-9)), low), high) - low) / (high - low)
        parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + width + 30}" height="{height}" '
                 'font-family="sans-serif" font-size="11">', '<rect width="100%" height="100%" fill="white"/>']
        for value in (0.1, 0.2, 0.5, 1, 2, 4, 5, 10, 20, 50, 100):
            x = x_of(value)
            parts.append(f'<line x1="{x:.1f}" y1="{top}" x2="{x:.1f}" y2="{height - 39}" stroke="{"#999" if value in (1, 4) else "#ddd"}"/>')
            parts.append(f'<text x="{x:.1f}" y="{height - 24}" text-anchor="middle">{value:g}</text>')
        for i, name in enumerate(self.names):
            colour = colours[i % len(colours)]
            x = 16 + (left + width) * i / (len(self.names) + 0.5)
            parts.append(f'<circle cx="{x:.0f}" cy="16" r="4" fill="{colour}"/><text x="{x + 8:.0f}" y="20">{escape(name)}</text>')
            for row, (_, entries) in enumerate(rows):
                parts.append(f'<circle cx="{x_of(gain(entries[YARDSTICK], entries[name])):.1f}" cy="{top + step * (row + 0.5):.1f}" '
                             f'r="4" fill="{colour}" fill-opacity="0.8"/>')
        for row, (place, _) in enumerate(rows):
            parts.append(f'<text x="{left - 8}" y="{top + step * (row + 0.5) + 4:.1f}" text-anchor="end">{escape(", ".join(place))}</text>')
        parts.append(f'<text x="{left + width / 2}" y="{height - 6}" text-anchor="middle">efficiency relative to the plain scalar tracker'
                     f' (what lies beyond the axis is drawn at its end)</text>')
        return "\n".join([*parts, "</svg>"]) + "\n"

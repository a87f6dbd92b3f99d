"""The journal paper's Table 2 with ours beside it, and in words where they differ and why."""
from common import markdown_rows
from papers import PAPER_FILTER, PAPER_VOLUMES, slices_of_cells
from sweeps_numbers import number, paragraph, spread, squared, times

CELL = 8
STAGES = {"layout": "row pairs", "march": "marching", "lookup": "lookups"}


class Measured:
    """What was measured of the papers' six volumes; `columns` are the rays, the papers' or in a trial run an eighth."""

    def __init__(self, results):
        self.results = results
        named = [key for key in [*results.runs, *results.failed] if key[0] == "table2"]
        self.columns = sorted({int(key[2].removeprefix("rays:")) for key in named})

    def key(self, name, rays, filter_):
        return ("table2", name.lower(), f"rays:{rays}", f"filter:{filter_}", "threads:1")

    def has(self, name, rays, *filters):
        return all(self.results.has(*self.key(name, rays, filter_)) for filter_ in ("none", *filters))

    def run(self, name, rays, filter_):
        return self.results.best(*self.key(name, rays, filter_))

    def seconds(self, name, rays, filter_="none"):
        return self.results.seconds(*self.key(name, rays, filter_))

    def overhead(self, name, rays, filter_):
        return self.seconds(name, rays, filter_) / self.seconds(name, rays) - 1

    def measured(self, rays, *filters):
        return [name for name in PAPER_FILTER if self.has(name, rays, *filters)]

    def papers(self, name, rays):
        return PAPER_FILTER[name][self.columns.index(rays)]

    def by_volume(self, cell):
        titles = {name: f"{name} {' × '.join(map(str, size))}" for name, size in PAPER_VOLUMES.items()}
        return markdown_rows(["volume", *map(squared, self.columns)],
                             [[title, *[cell(name, rays) for rays in self.columns]] for name, title in titles.items()])

    def table(self):
        def ours(name, rays):
            if not self.has(name, rays, "half"):
                return self.results.failed.get(self.key(name, rays, "none"), "–")
            return f"{number(self.seconds(name, rays))} ({self.overhead(name, rays, 'half'):.2f}×)"

        return self.by_volume(lambda name, rays: "{:.2f} ({:.2f}×) / ".format(*self.papers(name, rays)) + ours(name, rays))

    def alternatives(self):
        def added(name, rays, filter_):
            return f"{self.overhead(name, rays, filter_):.2f}×" if self.has(name, rays, filter_) else "–"

        return self.by_volume(lambda name, rays: " / ".join(added(name, rays, filter_) for filter_ in ("half", "full", "4x")))

    def other_rays(self):
        """The volumes whose sides are no powers of two, with the rays that were nearest to those wanted."""
        taken = {name: [round(self.run(name, rays, "none")["rays"]) for rays in self.columns if self.has(name, rays)]
                 for name in PAPER_FILTER}
        return [f"{name} has {', '.join(map(squared, rays))}" for name, rays in taken.items()
                if not set(rays) <= set(self.columns)]


def words_on_time(table):
    """How many times as fast, and what more rays cost."""
    columns = [rays for rays in table.columns if table.measured(rays)]
    few, most = columns[0], columns[-1]
    names = [name for name in table.measured(most) if table.has(name, few)]

    def grown(value):
        return spread([value(name, most) / value(name, few) for name in names], times)

    def steps(name, rays):
        return table.run(name, rays, "none")["voxel_steps"]

    def rate(rays):
        return number(sum(steps(name, rays) for name in names) / sum(table.seconds(name, rays) for name in names) / 1e9)

    def faster(rays):
        ratios = [table.papers(name, rays)[0] / table.seconds(name, rays) for name in table.measured(rays)]
        return f"{spread(ratios, times)} at {squared(rays)} rays"

    waits = spread([1e3 * table.papers(name, few)[0] / slices_of_cells(name, CELL) for name in names])
    return paragraph(
        f"Without the filter one core is faster than the GPU by {', '.join(map(faster, columns))}. From {squared(few)} to",
        f"{squared(most)} theirs take {grown(lambda *at: table.papers(*at)[0])} the time, ours {grown(table.seconds)}: our",
        f"slices lie as close as our rays, so that voxel steps grow {grown(steps)}. What is done for each cell stays the same,",
        f"so that steps a second rise from {rate(few)} G to {rate(most)} G. Theirs take {waits} ms for each slice of cells and",
        f"direction with {squared(few)} rays, hardly depending on the volume: so few rays do not fill a GPU.")


def words_on_filter(table):
    at = [(name, rays) for rays in table.columns for name in table.measured(rays, "half")]
    theirs = {pair: table.papers(*pair)[0] * table.papers(*pair)[1] for pair in at}
    ours = {pair: table.run(*pair, "half")["filter_s"] for pair in at}
    added = [table.overhead(*pair, "half") for pair in at]

    def a_slice(taken, unit):
        return spread([unit * time / slices_of_cells(name, CELL) for (name, _), time in taken.items()])

    return paragraph(
        f"The filter adds {spread([table.papers(*pair)[1] for pair in at], times)} in theirs, which is {spread(theirs.values())}",
        f"s, and {min(added):.2f}× to {max(added):.2f}× in ours, of which the filter itself takes {spread(ours.values())} s by",
        "the program's own clock (differences of some hundredths, negative ones too, are what two measurements differ by). Both",
        "filter slices of cells, not of rays: its seconds are the same for any number of rays, and its share falls as they are",
        f"added. Theirs take {a_slice(theirs, 1e3)} ms for a slice of one direction, ours {a_slice(ours, 1e6)} µs.")


def words_on_directions(table):
    """Four times the directions, by what each stage costs more."""
    at = [(name, rays) for rays in table.columns for name in table.measured(rays, "half", "full", "4x")]

    def whole(filter_, stage):
        return sum(table.run(*pair, filter_)[f"{stage}_s"] for pair in at)

    def added(filter_):
        return spread([table.overhead(*pair, filter_) for pair in at], lambda x: f"{x:.2f}×")

    more = ", ".join(f"{name} {times(whole('4x', stage) / whole('none', stage))}" for stage, name in STAGES.items())
    return paragraph(
        f"Four times the directions add {added('4x')} (the papers: 3×), the filter {added('half')} where both were measured. It",
        f"is more than 3× because directions share less: {more} the time. Without oversampling up to six directions of one axis",
        "are marched over the same pairs of voxel rows; of one texel's four lines not all run along one axis, and their V has",
        f"to be summed. The filter itself takes {whole('full', 'filter') / whole('half', 'filter'):.2f} times as long with the",
        "full angle; the papers, too, found its size to matter little.")


def section(results):
    table = Measured(results)
    nearest = f"The nearest number was taken: {'; '.join(table.other_rays())}." if table.other_rays() else ""
    filtered = table.measured(table.columns[0], "half")
    return [
        "## The papers' Table 2", "",
        paragraph(
            "Seconds without the filter and what the filter (half angle) adds, as a multiple of them: the papers' (GTX Titan,",
            "cells of 8³ voxels) / ours (one core). Their volumes are not to be had; ours are generated in the same sizes:",
            "smoke-like plumes for Smoke and Fluid, CT-like heads, stretched to the box, for the others. Our rays lie one voxel",
            "apart, or 2, 4 …; more of them than the longest side has voxels are had by doubling the voxels of each axis, in 8",
            "bits, with cells of 16³ or 32³ of the new voxels, which leaves their number as it was. Rays are counted along the",
            "longest side; shorter ones have fewer.",
            nearest), "",
        table.table(), "",
        *((words_on_time(table), "", words_on_filter(table), "") if filtered else ()),
        "What is added by the filter of half the angle / of the full angle / by four times the directions instead:", "",
        table.alternatives(), "",
        *((words_on_directions(table), "") if table.measured(table.columns[0], "half", "full", "4x") else ())]

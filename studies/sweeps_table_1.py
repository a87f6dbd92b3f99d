"""The journal paper's Table 1 with ours beside it, and in words where they differ and why."""
from common import markdown_rows
from papers import PAPER_BRUTE_FORCE, PAPER_CELLS, PAPER_MEGABYTES, PAPER_SWEEPS, slices_of_cells
from sweeps_numbers import brute_force_seconds, number, paragraph, seconds, spread, squared, sweep_key, times


def measured_cells(results):
    return [cell for cell in PAPER_CELLS if results.has("brute_force", "ct", f"cell:{cell}", "threads:1")]


def table(results):
    cells = measured_cells(results)
    rays = results.values("sweep", "ct", "rays")

    def megabytes(c):
        return number(results.best(*sweep_key("ct", rays[0], c, "half"))["grid_bytes"] / 1e6)

    def forced(c):
        whole, share, run = brute_force_seconds(results, "ct", c)
        return number(whole) if share == 1 else f"{whole:.0f} ± {whole * run['relative_error']:.0f} ({share:.1%} of the cells)"

    def gain(r, c, filter_):
        return times(brute_force_seconds(results, "ct", c)[0] / results.seconds(*sweep_key("ct", r, c, filter_)))

    def papers(r, c, show=str):
        return show(PAPER_SWEEPS[r][PAPER_CELLS.index(c)]) if r in PAPER_SWEEPS else "–"

    rows = [["memory of V, MB", *[f"{PAPER_MEGABYTES[PAPER_CELLS.index(c)]} / {megabytes(c)}" for c in cells]]]
    for r in rays:
        ours = [[seconds(results, *sweep_key("ct", r, c, filter_)) for filter_ in ("none", "half")] for c in cells]
        rows.append([f"sweep, {squared(r)}", *[" / ".join([papers(r, c), *both]) for c, both in zip(cells, ours)]])
    rows.append(["brute force", *[f"{PAPER_BRUTE_FORCE[PAPER_CELLS.index(c)]} / {forced(c)}" for c in cells]])
    for r in rays[-2:]:
        rows.append([f"brute force over {squared(r)}", *[
            " / ".join([papers(r, c, lambda s, c=c: times(PAPER_BRUTE_FORCE[PAPER_CELLS.index(c)] / s)),
                        *[gain(r, c, filter_) for filter_ in ("none", "half")]]) for c in cells]])
    return markdown_rows(["", *[f"cells of {c}³ voxels" for c in cells]], rows)


def words(results):
    cells = measured_cells(results)
    rays = [r for r in results.values("sweep", "ct", "rays") if r in PAPER_SWEEPS]
    fewest, most, finest = rays[0], rays[-1], cells[0]

    def theirs(r, c):
        return PAPER_SWEEPS[r][PAPER_CELLS.index(c)]

    def ours(r, c):
        return results.seconds(*sweep_key("ct", r, c, "none"))

    def stage(r, c, name):
        return number(results.best(*sweep_key("ct", r, c, "none"))[f"{name}_s"])

    def a_slice(seconds_of, unit):
        return spread([unit * seconds_of(fewest, c) / slices_of_cells("Manix", c) for c in cells])

    forced = {c: (PAPER_BRUTE_FORCE[PAPER_CELLS.index(c)], brute_force_seconds(results, "ct", c)[0]) for c in cells}
    return paragraph(
        f"Unfiltered, one core is {spread([theirs(r, c) / ours(r, c) for r in rays for c in cells], times)} as fast as their",
        f"GPU; at {squared(most)} rays {', '.join(times(theirs(most, c) / ours(most, c)) for c in cells)} from the smallest",
        f"cells to the largest. With {squared(fewest)} rays theirs take {a_slice(theirs, 1e3)} ms for each slice of cells and",
        f"direction, however many cells it has: what a step of a GPU costs. Ours follow the cells, {a_slice(ours, 1e6)} µs a",
        f"slice. From {squared(most)} rays to {squared(fewest)} and cells of {finest}³ voxels theirs fall from",
        f"{theirs(most, finest):.2f} to {theirs(fewest, finest):.2f} s; ours go from {number(ours(most, finest))} to",
        f"{number(ours(fewest, finest))} s: marching falls from {stage(most, finest, 'march')} to",
        f"{stage(fewest, finest, 'march')} s, but lookups, {stage(most, finest, 'lookup')} and {stage(fewest, finest, 'lookup')}",
        "s, are most of it, one for every cell and direction however few rays there are. Where a whole number of rays lies from",
        "cell to cell they are read in order; where less than one does, each cell gathers its own, which is slower. Brute force",
        f"takes ours {spread([b / a for a, b in forced.values()], times)} their seconds: its rays are independent of each other,",
        "which fills a GPU as slices that wait for each other do not. So sweeping gains",
        f"{spread([a / theirs(most, c) for c, (a, _) in forced.items()], times)} there at {squared(most)} rays,",
        f"{spread([b / ours(most, c) for c, (_, b) in forced.items()], times)} here.")


def section(results):
    gathers = results.best("brute_force", "ct", "cell:8", "threads:1").get("label", "")
    return [
        "## The papers' Table 1", "",
        paragraph(
            "Seconds: the papers' (GeForce GTX 760, Manix 512 × 512 × 460, unfiltered) / ours unfiltered / ours filtered",
            "(CT-like of the same size, one core). Brute force: the papers' / ours (`bench/brute_force.h`: one sample a voxel,",
            f"{gathers} gathers, ends where 1/512 is left). Where a share is given, random blocks of rows of cells were marched",
            f"(seed {results.context['brute_force_seed']}) and scaled; ± is the standard error of the choice."), "",
        table(results), "", words(results), ""]

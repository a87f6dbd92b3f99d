// Where the cells of each slice look up, what the box's sides do there, and the filter's boxes: a few numbers for each
// cell along u and along v, in double precision, which the kernels for all cells read.
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/sweep_kernels.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// A block takes 128 cells of one slice along one axis of the plane, and one more that ends the last tile.
struct PlaceCells {
    static constexpr int threads = 128, blocks_a_multiprocessor = 8;
    SweepBatch batch;
    double extinction_of_one, tan_beta;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        const int line = block.index.z / 2, plane_axis = block.index.z % 2, w = block.index.y;
        const LineView& view = batch.line(line);
        if (w >= view.cells)
            return;
        block.run_apart([&](int thread) {
            const int cell = block.index.x * threads + thread;
            if (cell <= view.plane_axis(plane_axis).cells)
                place(view, line, w, plane_axis, cell);
        });
    }

private:
    LUMISWEEP_HD void place(const LineView& view, int line, int w, int plane_axis, int cell) const
    {
        const SweepScratch& scratch = batch.scratch;
        const LineAxis& axis = view.plane_axis(plane_axis);
        const double depth = lookup_depth(w, view.cell_side);
        const CellRow row(axis.rays, axis.cell_side, depth);
        const CellPlace place = row.place(cell);
        if (cell < axis.cells) {
            const std::size_t at = scratch.cells(line, w, plane_axis) + static_cast<std::size_t>(cell);
            scratch.places[at] = place;
            scratch.sides[at] = sides_of(axis.rays, batch.lines.begin + axis.ranges, batch.lines.end + axis.ranges, row,
                                         cell, place.ray);
        }
        begin_tiles(axis, row, scratch.tiles(line, w, plane_axis), tile_step(plane_axis), cell);
        SliceView& slice = scratch.slices[scratch.slice(line, w)];
        if (cell == 0 && plane_axis == 0) {
            slice.depth = static_cast<float>(depth);
            slice.weight = static_cast<float>(weight_at(depth));
            slice.scale = optical_scale(extinction_of_one, view.slice_world);
        }
        for (int side = 0; side < 2; ++side) {
            if (!(tan_beta > 0.0)) {
                if (cell == 0)
                    slice.box[plane_axis][side] = {-1, 0};
                continue;
            }
            const double distance = side == 0 ? depth : view.slices - depth;
            const Box box(box_side(distance, view.slice_world, tan_beta, axis.cell_side_world), axis.cells);
            if (cell == 0)
                slice.box[plane_axis][side] = {box.is_identity(axis.cells) ? -1 : box.reach, box.shift};
            if (cell < axis.cells)
                scratch.scales_of(line, w, plane_axis, side)[cell] = box.scales(cell, axis.cells);
        }
    }

    /// The tiles whose first cell this is; cells look up at rays in their order.
    LUMISWEEP_HD static void begin_tiles(const LineAxis& axis, const CellRow& row, std::int32_t* tiles, int step,
                                         int cell)
    {
        const int before = cell > 0 ? row.place(cell - 1).ray / step : -1;
        const int last = cell < axis.cells ? row.place(cell).ray / step : tiles_of(axis.ray_count, step);
        for (int tile = before + 1; tile <= last; ++tile)
            tiles[tile] = cell;
    }
};

} // namespace

void place_cells(const SweepBatch& batch, double extinction_of_one, double tan_beta, const Stream& stream)
{
    const int cells = batch.scratch.most_cells;
    launch("placing cells", stream, {cells / PlaceCells::threads + 1, cells, 2 * batch.line_count}, 0,
           PlaceCells{batch, extinction_of_one, tan_beta});
}

} // namespace lumisweep::LUMISWEEP_CUDA

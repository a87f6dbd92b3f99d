// Bodies of sweep_kernel.h, included by one file per instruction set after it has defined `Rays`, sixteen rays of one
// parity, `store_lines`, `stream_lines`, `fence_lines` and LUMISWEEP_SWEEP_KERNELS with the table's name. Everything is
// static and uses no inline function of any header but those that are always inlined, of what the GPU does, too: the
// linker must not mix instruction sets.
#include "lumisweep/visibility/sweep_box.h"
#include "lumisweep/visibility/sweep_optics.h"

namespace lumisweep {
namespace {

void make_pairs(std::uint8_t* __restrict pairs, const std::uint8_t* low, const std::uint8_t* high, int count)
{
    for (int i = 0; i < count; ++i) {
        pairs[2 * i] = low[i];
        pairs[2 * i + 1] = high[i];
    }
    for (int i = 0; i < edge_voxels; ++i) {
        pairs[-2 * i - 2] = low[0];
        pairs[-2 * i - 1] = high[0];
        pairs[2 * (count + i)] = low[count - 1];
        pairs[2 * (count + i) + 1] = high[count - 1];
    }
}

/// row_count ≤ march_slices.
template <int row_count>
void march_rows(std::int32_t* even, std::int32_t* odd, const MarchRow* rows, const MarchBlocks& blocks)
{
    const std::uint8_t* pairs[row_count];
    Rays::Weights weights[row_count];
    for (int r = 0; r < row_count; ++r) {
        pairs[r] = rows[r].pairs;
        weights[r] = Rays::weights(rows[r].weight);
    }
    for (int e = 0; e < blocks.edge_count; ++e) {
        const std::ptrdiff_t at = blocks.edge[e] * (ray_block / 2);
        Rays sum_even = Rays::load(even + at), sum_odd = Rays::load(odd + at);
        for (int r = 0; r < row_count; ++r) {
            const std::uint32_t counted = rows[r].counted[e];
            sum_even.add_some(pairs[r] + 4 * at, weights[r], counted & 0xffffU);
            sum_odd.add_some(pairs[r] + 4 * at + 2, weights[r], counted >> 16);
        }
        sum_even.store(even + at);
        sum_odd.store(odd + at);
    }
    const std::ptrdiff_t last = static_cast<std::ptrdiff_t>(blocks.last) * (ray_block / 2);
    for (std::ptrdiff_t at = static_cast<std::ptrdiff_t>(blocks.first) * (ray_block / 2); at < last;
         at += ray_block / 2) {
        Rays sum_even = Rays::load(even + at), sum_odd = Rays::load(odd + at);
        for (int r = 0; r < row_count; ++r) {
            sum_even.add(pairs[r] + 4 * at, weights[r]);
            sum_odd.add(pairs[r] + 4 * at + 2, weights[r]);
        }
        sum_even.store(even + at);
        sum_odd.store(odd + at);
    }
}

void march(std::int32_t* even, std::int32_t* odd, const MarchRow* rows, int row_count, const MarchBlocks& blocks)
{
    switch (row_count) {
    case 8: return march_rows<8>(even, odd, rows, blocks);
    case 7: return march_rows<7>(even, odd, rows, blocks);
    case 6: return march_rows<6>(even, odd, rows, blocks);
    case 5: return march_rows<5>(even, odd, rows, blocks);
    case 4: return march_rows<4>(even, odd, rows, blocks);
    case 3: return march_rows<3>(even, odd, rows, blocks);
    case 2: return march_rows<2>(even, odd, rows, blocks);
    case 1: return march_rows<1>(even, odd, rows, blocks);
    default: return;
    }
}

/// Every `step`-th stored ray and its neighbour.
template <int step>
inline __attribute__((always_inline)) void look_up_evenly(float* __restrict tau, const LookupRow& row)
{
    const std::int32_t *low = row.low + row.index[0], *low_next = row.low + row.next[0];
    const std::int32_t *high = row.high + row.index[0], *high_next = row.high + row.next[0];
    const float f = row.fraction[0], f_rows = row.fraction_rows;
    const int count = row.count;
    for (int c = 0; c < count; ++c)
        tau[c] = between_rays(low[step * c], low_next[step * c], high[step * c], high_next[step * c], f, f_rows);
}

/// Cells on neighbouring rays: two at a time, of which the first lies between rays k of either parity and the second
/// between the same ray of the second parity and ray k + 1 of the first.
void look_up_neighbours(float* __restrict tau, const LookupRow& row)
{
    const std::int32_t *low = row.low + row.index[0], *low_next = row.low + row.next[0];
    const std::int32_t *high = row.high + row.index[0], *high_next = row.high + row.next[0];
    const float f = row.fraction[0], f_rows = row.fraction_rows;
    const int pairs = row.count / 2;
    for (int k = 0; k < pairs; ++k) {
        tau[2 * k] = between_rays(low[k], low_next[k], high[k], high_next[k], f, f_rows);
        tau[2 * k + 1] = between_rays(low_next[k], low[k + 1], high_next[k], high[k + 1], f, f_rows);
    }
    if (row.count % 2 != 0)
        tau[2 * pairs] = between_rays(low[pairs], low_next[pairs], high[pairs], high_next[pairs], f, f_rows);
}

void look_up(float* __restrict tau, const LookupRow& row)
{
    switch (row.step) {
    case neighbouring_rays: return look_up_neighbours(tau, row);
    case 1: return look_up_evenly<1>(tau, row);
    case 2: return look_up_evenly<2>(tau, row);
    case 4: return look_up_evenly<4>(tau, row);
    default: break;
    }
    const std::int32_t *low = row.low, *high = row.high, *index = row.index, *next = row.next;
    const float* fraction = row.fraction;
    const float f_rows = row.fraction_rows;
    const int count = row.count;
    for (int c = 0; c < count; ++c)
        tau[c] = between_rays(low[index[c]], low[next[c]], high[index[c]], high[next[c]], fraction[c], f_rows);
}

void side_factors(float* __restrict forwards, float* __restrict backwards, const SideRow& row)
{
    const int count = row.count;
    const RowSides row_sides = row.row;
    const float depth = row.depth, weight = row.weight, scale = row.scale;
    const float *begin_low = row.begin_low, *begin_high = row.begin_high, *end_low = row.end_low;
    const float *end_high = row.end_high, *enter = row.enter, *leave = row.leave, *fraction = row.fraction;
    for (int c = 0; c < count; ++c) {
        const SideFactors factors = side_factors_of(begin_low[c], begin_high[c], end_low[c], end_high[c], enter[c],
                                                    leave[c], fraction[c], row_sides, depth, weight, scale);
        forwards[c] = factors.forwards;
        backwards[c] = factors.backwards;
    }
}

/// A constant that the compiler does not see through: it would split loops into branches for its special cases instead
/// of vectorising them.
inline __attribute__((always_inline)) float opaque(float constant)
{
    asm("" : "+m"(constant));
    return constant;
}

void to_visibility(std::uint16_t* __restrict visibility, const float* __restrict tau, const float* __restrict factor,
                   int count)
{
    const float most = opaque(most_depth);
    for (int i = 0; i < count; ++i)
        visibility[i] = fixed_visibility(tau[i] * factor[i], most);
}

void to_visibility_of_rest(std::uint16_t* __restrict visibility, const float* __restrict total,
                           const float* __restrict tau, const float* __restrict factor, int count)
{
    const float most = opaque(most_depth);
    for (int i = 0; i < count; ++i)
        visibility[i] = fixed_visibility((total[i] - tau[i]) * factor[i], most);
}

void add(std::uint16_t* out, const std::uint16_t* a, const std::uint16_t* b, int count)
{
    for (int i = 0; i < count; ++i)
        out[i] = static_cast<std::uint16_t>(a[i] + b[i]);
}

/// Nearly all boxes are narrow enough for whole values, and a shift by a variable takes 32-bit lanes.
struct Whole {
    std::uint16_t operator()(std::uint16_t v) const { return v; }
};
struct Shifted {
    int shift, half;
    std::uint16_t operator()(std::uint16_t v) const { return shifted_visibility(v, shift, half); }
};

template <class Value>
inline __attribute__((always_inline)) void slide_by(Value value, std::uint16_t* __restrict sums,
                                                    const std::uint16_t* __restrict entering,
                                                    const std::uint16_t* __restrict leaving, int count)
{
    for (int i = 0; i < count; ++i)
        sums[i] = static_cast<std::uint16_t>(sums[i] + value(entering[i]) - value(leaving[i]));
}

void slide(std::uint16_t* __restrict sums, const std::uint16_t* __restrict entering,
           const std::uint16_t* __restrict leaving, int shift, int count)
{
    if (shift == 0)
        slide_by(Whole{}, sums, entering, leaving, count);
    else
        slide_by(Shifted{shift, (1 << shift) >> 1}, sums, entering, leaving, count);
}

void box_mean(std::uint16_t* __restrict out, const std::uint16_t* __restrict whole, const std::uint16_t* __restrict low,
              const std::uint16_t* __restrict high, const std::uint16_t* __restrict scale_whole,
              const std::uint16_t* __restrict scale_ends, int count)
{
    for (int i = 0; i < count; ++i) {
        const auto ends = static_cast<std::uint16_t>(low[i] + high[i]);
        out[i] = BoxScales{scale_whole[i], scale_ends[i]}.mean(whole[i], ends);
    }
}

template <class Value>
inline __attribute__((always_inline)) void
box_mean_by(Value value, std::uint16_t* __restrict out, const std::uint16_t* __restrict whole,
            const std::uint16_t* __restrict low, const std::uint16_t* __restrict high, std::uint16_t scale_whole,
            std::uint16_t scale_ends, int count)
{
    for (int i = 0; i < count; ++i) {
        const auto ends = static_cast<std::uint16_t>(value(low[i]) + value(high[i]));
        out[i] = BoxScales{scale_whole, scale_ends}.mean(whole[i], ends);
    }
}

void box_mean_row(std::uint16_t* __restrict out, const std::uint16_t* __restrict whole,
                  const std::uint16_t* __restrict low, const std::uint16_t* __restrict high, int shift,
                  std::uint16_t scale_whole, std::uint16_t scale_ends, int count)
{
    if (shift == 0)
        box_mean_by(Whole{}, out, whole, low, high, scale_whole, scale_ends, count);
    else
        box_mean_by(Shifted{shift, (1 << shift) >> 1}, out, whole, low, high, scale_whole, scale_ends, count);
}

void store(std::uint8_t* __restrict out, const std::uint16_t* __restrict in, int count)
{
    const int done = store_lines(out, in, count);
    for (int i = done; i < count; ++i)
        out[i] = stored_visibility(in[i]);
}

void stream(float* __restrict out, const float* __restrict in, int count)
{
    const int done = stream_lines(out, in, count);
    for (int i = done; i < count; ++i)
        out[i] = in[i];
}

void finish_stores() { fence_lines(); }

} // namespace

const SweepKernels LUMISWEEP_SWEEP_KERNELS = {LUMISWEEP_SWEEP_KERNELS_NAME,
                                              make_pairs,
                                              march,
                                              look_up,
                                              side_factors,
                                              to_visibility,
                                              to_visibility_of_rest,
                                              add,
                                              slide,
                                              box_mean,
                                              box_mean_row,
                                              store,
                                              stream,
                                              finish_stores};

} // namespace lumisweep

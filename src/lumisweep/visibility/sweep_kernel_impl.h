// Bodies of sweep_kernel.h, included by one file per instruction set after it has defined `Rays`, sixteen rays of one
// parity, `store_lines`, `stream_lines`, `fence_lines` and LUMISWEEP_SWEEP_KERNELS with the table's name. Everything is
// static and uses no inline function of any header: the linker must not mix instruction sets.
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
    const float f = row.fraction[0], rest = 1.0F - f;
    const float f_rows = row.fraction_rows, rest_rows = 1.0F - f_rows;
    const int count = row.count;
    for (int c = 0; c < count; ++c) {
        const float below = static_cast<float>(low[step * c]) * rest + static_cast<float>(low_next[step * c]) * f;
        const float above = static_cast<float>(high[step * c]) * rest + static_cast<float>(high_next[step * c]) * f;
        tau[c] = below * rest_rows + above * f_rows;
    }
}

/// Cells on neighbouring rays: two at a time, of which the first lies between rays k of either parity and the second
/// between the same ray of the second parity and ray k + 1 of the first.
void look_up_neighbours(float* __restrict tau, const LookupRow& row)
{
    const std::int32_t *low = row.low + row.index[0], *low_next = row.low + row.next[0];
    const std::int32_t *high = row.high + row.index[0], *high_next = row.high + row.next[0];
    const float f = row.fraction[0], rest = 1.0F - f;
    const float f_rows = row.fraction_rows, rest_rows = 1.0F - f_rows;
    const auto mix = [&](std::int32_t a, std::int32_t b) __attribute__((always_inline))
    {
        return static_cast<float>(a) * rest + static_cast<float>(b) * f;
    };
    const int pairs = row.count / 2;
    for (int k = 0; k < pairs; ++k) {
        tau[2 * k] = mix(low[k], low_next[k]) * rest_rows + mix(high[k], high_next[k]) * f_rows;
        tau[2 * k + 1] = mix(low_next[k], low[k + 1]) * rest_rows + mix(high_next[k], high[k + 1]) * f_rows;
    }
    if (row.count % 2 != 0)
        tau[2 * pairs] = mix(low[pairs], low_next[pairs]) * rest_rows + mix(high[pairs], high_next[pairs]) * f_rows;
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
    const float f_rows = row.fraction_rows, rest_rows = 1.0F - f_rows;
    const int count = row.count;
    for (int c = 0; c < count; ++c) {
        const float f = fraction[c], rest = 1.0F - f;
        const float below = static_cast<float>(low[index[c]]) * rest + static_cast<float>(low[next[c]]) * f;
        const float above = static_cast<float>(high[index[c]]) * rest + static_cast<float>(high[next[c]]) * f;
        tau[c] = below * rest_rows + above * f_rows;
    }
}

inline __attribute__((always_inline)) float lesser(float a, float b) { return a < b ? a : b; }
inline __attribute__((always_inline)) float greater(float a, float b) { return a > b ? a : b; }
/// part / weight, 0 where nothing was counted.
inline __attribute__((always_inline)) float per_weight(float part, float weight)
{
    const float quotient = greater(part, 0.0F) / greater(weight, 1e-3F); // weights are whole numbers in [0, 1] parts
    return weight > 0.0F ? quotient : 0.0F;
}

void side_factors(float* __restrict forwards, float* __restrict backwards, const SideRow& row)
{
    const int count = row.count;
    const float f_rows = row.fraction_rows, rest_rows = 1.0F - f_rows;
    const float depth = row.depth, weight = row.weight, scale = row.scale;
    const float row_begin0 = row.row_begin[0], row_begin1 = row.row_begin[1];
    const float row_end0 = row.row_end[0], row_end1 = row.row_end[1];
    const float row_enter = row.row_enter, row_leave = row.row_leave;
    const float *begin_low = row.begin_low, *begin_high = row.begin_high, *end_low = row.end_low;
    const float *end_high = row.end_high, *enter = row.enter, *leave = row.leave, *fraction = row.fraction;
    for (int c = 0; c < count; ++c) {
        const float f = fraction[c], rest = 1.0F - f;
        const float begin0 = greater(begin_low[c], row_begin0), begin1 = greater(begin_high[c], row_begin0);
        const float begin2 = greater(begin_low[c], row_begin1), begin3 = greater(begin_high[c], row_begin1);
        const float end0 = lesser(end_low[c], row_end0), end1 = lesser(end_high[c], row_end0);
        const float end2 = lesser(end_low[c], row_end1), end3 = lesser(end_high[c], row_end1);
        const float until0 = greater(lesser(end0, weight) - begin0, 0.0F);
        const float until1 = greater(lesser(end1, weight) - begin1, 0.0F);
        const float until2 = greater(lesser(end2, weight) - begin2, 0.0F);
        const float until3 = greater(lesser(end3, weight) - begin3, 0.0F);
        const float from0 = greater(end0 - greater(begin0, weight), 0.0F);
        const float from1 = greater(end1 - greater(begin1, weight), 0.0F);
        const float from2 = greater(end2 - greater(begin2, weight), 0.0F);
        const float from3 = greater(end3 - greater(begin3, weight), 0.0F);
        const float until = (until0 * rest + until1 * f) * rest_rows + (until2 * rest + until3 * f) * f_rows;
        const float from = (from0 * rest + from1 * f) * rest_rows + (from2 * rest + from3 * f) * f_rows;
        forwards[c] = per_weight(depth - greater(enter[c], row_enter), until) * scale;
        backwards[c] = per_weight(lesser(leave[c], row_leave) - depth, from) * scale;
    }
}

/// A constant that the compiler does not see through: it would split loops into branches for its special cases instead
/// of vectorising them.
inline __attribute__((always_inline)) float opaque(float constant)
{
    asm("" : "+m"(constant));
    return constant;
}

/// 2^−y in whole_visibility, at most 1; 0 from y = most = 30 on. Relative error below 8e−5.
inline __attribute__((always_inline)) std::uint16_t fixed_visibility(float y, float most)
{
    const float bounded = lesser(y, most);
    const int whole = static_cast<int>(bounded + 0.5F);  // below 0 by no more than rounding
    const float f = static_cast<float>(whole) - bounded; // −1/2 … 1/2
    // 2^f by the cubic of least relative error.
    float p = 0.05517167F * whole_visibility;
    p = p * f + 0.24261112F * whole_visibility;
    p = p * f + 0.69326099F * whole_visibility;
    p = p * f + 0.99992807F * whole_visibility;
    const int v = static_cast<int>(__builtin_bit_cast(float, __builtin_bit_cast(int, p) - (whole << 23)) + 0.5F);
    return static_cast<std::uint16_t>(v < whole_visibility ? v : whole_visibility);
}

void to_visibility(std::uint16_t* __restrict visibility, const float* __restrict tau, const float* __restrict factor,
                   int count)
{
    const float most = opaque(30.0F);
    for (int i = 0; i < count; ++i)
        visibility[i] = fixed_visibility(tau[i] * factor[i], most);
}

void to_visibility_of_rest(std::uint16_t* __restrict visibility, const float* __restrict total,
                           const float* __restrict tau, const float* __restrict factor, int count)
{
    const float most = opaque(30.0F);
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
    std::uint16_t operator()(std::uint16_t v) const { return static_cast<std::uint16_t>((v + half) >> shift); }
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

inline __attribute__((always_inline)) std::uint16_t high_product(std::uint16_t a, std::uint16_t b)
{
    return static_cast<std::uint16_t>((static_cast<std::uint32_t>(a) * b) >> 16);
}

void box_mean(std::uint16_t* __restrict out, const std::uint16_t* __restrict whole, const std::uint16_t* __restrict low,
              const std::uint16_t* __restrict high, const std::uint16_t* __restrict scale_whole,
              const std::uint16_t* __restrict scale_ends, int count)
{
    for (int i = 0; i < count; ++i) {
        const auto ends = static_cast<std::uint16_t>(low[i] + high[i]);
        out[i] = static_cast<std::uint16_t>(high_product(whole[i], scale_whole[i]) + high_product(ends, scale_ends[i]));
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
        out[i] = static_cast<std::uint16_t>(high_product(whole[i], scale_whole) + high_product(ends, scale_ends));
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
        out[i] = static_cast<std::uint8_t>((in[i] + 8) >> 4);
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

// Bodies of sweep_kernel.h, included by one file per instruction set after it has defined `Rays`, sixteen rays of one
// parity, and LUMISWEEP_SWEEP_KERNELS with the table's name. Everything is static and uses no inline function of any
// header: the linker must not mix instruction sets.
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

inline __attribute__((always_inline)) int clamp_to_block(int ray, int block)
{
    const int i = ray - block * ray_block;
    return i < 0 ? 0 : i > ray_block ? ray_block : i;
}

inline __attribute__((always_inline)) int bits_between(int first, int last)
{
    return first < last ? (1 << last) - (1 << first) : 0;
}

/// A block in which not every piece counts every ray.
void march_edge(std::int32_t* even, std::int32_t* odd, const MarchRow* rows, int row_count, int block)
{
    Rays sum_even = Rays::load(even + block * (ray_block / 2)), sum_odd = Rays::load(odd + block * (ray_block / 2));
    for (int r = 0; r < row_count; ++r) {
        const int first = clamp_to_block(rows[r].first, block), last = clamp_to_block(rows[r].last, block);
        if (first >= last)
            continue;
        const std::uint8_t* pairs = rows[r].pairs + 2 * ray_block * block;
        const Rays::Weights weights = Rays::weights(rows[r].weight);
        sum_even.add_some(pairs, weights, bits_between((first + 1) / 2, (last + 1) / 2));
        sum_odd.add_some(pairs + 2, weights, bits_between(first / 2, last / 2));
    }
    sum_even.store(even + block * (ray_block / 2));
    sum_odd.store(odd + block * (ray_block / 2));
}

template <int row_count>
inline __attribute__((always_inline)) void march_blocks(std::int32_t* even, std::int32_t* odd, const MarchRow* rows,
                                                        int first_block, int last_block)
{
    const std::uint8_t* pairs[row_count];
    Rays::Weights weights[row_count];
    for (int r = 0; r < row_count; ++r) {
        pairs[r] = rows[r].pairs;
        weights[r] = Rays::weights(rows[r].weight);
    }
    for (int block = first_block; block < last_block; ++block) {
        std::int32_t* block_even = even + block * (ray_block / 2);
        std::int32_t* block_odd = odd + block * (ray_block / 2);
        Rays sum_even = Rays::load(block_even), sum_odd = Rays::load(block_odd);
        for (int r = 0; r < row_count; ++r) {
            sum_even.add(pairs[r] + 2 * ray_block * block, weights[r]);
            sum_odd.add(pairs[r] + 2 * ray_block * block + 2, weights[r]);
        }
        sum_even.store(block_even);
        sum_odd.store(block_odd);
    }
}

template <int row_count>
void march_some(std::int32_t* even, std::int32_t* odd, const MarchRow* rows)
{
    int first = rows[0].first, last = rows[0].last, inner_first = first, inner_last = last;
    for (int r = 1; r < row_count; ++r) {
        first = rows[r].first < first ? rows[r].first : first;
        last = rows[r].last > last ? rows[r].last : last;
        inner_first = rows[r].first > inner_first ? rows[r].first : inner_first;
        inner_last = rows[r].last < inner_last ? rows[r].last : inner_last;
    }
    const int end_block = (last + ray_block - 1) / ray_block;
    int inner_begin = (inner_first + ray_block - 1) / ray_block, inner_end = inner_last / ray_block;
    if (inner_begin >= inner_end)
        inner_begin = inner_end = end_block;
    for (int block = first / ray_block; block < inner_begin; ++block)
        march_edge(even, odd, rows, row_count, block);
    march_blocks<row_count>(even, odd, rows, inner_begin, inner_end);
    for (int block = inner_end; block < end_block; ++block)
        march_edge(even, odd, rows, row_count, block);
}

void march(std::int32_t* even, std::int32_t* odd, const MarchRow* rows, int row_count)
{
    for (; row_count > 8; row_count -= 8, rows += 8)
        march_some<8>(even, odd, rows);
    switch (row_count) {
    case 8: return march_some<8>(even, odd, rows);
    case 7: return march_some<7>(even, odd, rows);
    case 6: return march_some<6>(even, odd, rows);
    case 5: return march_some<5>(even, odd, rows);
    case 4: return march_some<4>(even, odd, rows);
    case 3: return march_some<3>(even, odd, rows);
    case 2: return march_some<2>(even, odd, rows);
    case 1: return march_some<1>(even, odd, rows);
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

void look_up(float* __restrict tau, const LookupRow& row)
{
    switch (row.step) {
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
    return weight > 0.0F ? greater(part, 0.0F) / weight : 0.0F;
}

void side_factors(float* __restrict forwards, float* __restrict backwards, const SideRow& row)
{
    const int count = row.count;
    const float f_rows = row.fraction_rows, rest_rows = 1.0F - f_rows;
    const float depth = row.depth, weight = row.weight;
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
        forwards[c] = per_weight(depth - greater(enter[c], row_enter), until);
        backwards[c] = per_weight(lesser(leave[c], row_leave) - depth, from);
    }
}

/// exp(−x) for x ≥ 0, relative error below 5e−5 until it flushes to 3e−38 at x = 87.
inline __attribute__((always_inline)) float exp_minus(float x)
{
    const float y = (x < 87.0F ? x : 87.0F) * -1.44269504F;
    const int whole = static_cast<int>(y - 0.5F); // y ≤ 0: rounds to nearest
    const float f = (y - static_cast<float>(whole)) * 0.69314718F;
    float p = 1.0F / 24.0F;
    p = p * f + 1.0F / 6.0F;
    p = p * f + 0.5F;
    p = p * f + 1.0F;
    p = p * f + 1.0F;
    return p * __builtin_bit_cast(float, (whole + 127) << 23);
}

inline __attribute__((always_inline)) std::uint16_t fixed_visibility(float tau)
{
    return static_cast<std::uint16_t>(
        static_cast<int>(exp_minus(greater(tau, 0.0F)) * static_cast<float>(whole_visibility) + 0.5F));
}

void to_visibility(std::uint16_t* __restrict visibility, const float* total, const float* tau, const float* factor,
                   float scale, int count)
{
    if (total == nullptr)
        for (int i = 0; i < count; ++i)
            visibility[i] = fixed_visibility(tau[i] * (factor[i] * scale));
    else
        for (int i = 0; i < count; ++i)
            visibility[i] = fixed_visibility((total[i] - tau[i]) * (factor[i] * scale));
}

void add(std::uint16_t* out, const std::uint16_t* a, const std::uint16_t* b, int count)
{
    for (int i = 0; i < count; ++i)
        out[i] = static_cast<std::uint16_t>(a[i] + b[i]);
}

void slide(std::uint16_t* __restrict sums, const std::uint16_t* __restrict entering,
           const std::uint16_t* __restrict leaving, int shift, int count)
{
    for (int i = 0; i < count; ++i)
        sums[i] = static_cast<std::uint16_t>(sums[i] + (entering[i] >> shift) - (leaving[i] >> shift));
}

inline __attribute__((always_inline)) std::uint16_t high_product(std::uint16_t a, std::uint16_t b)
{
    return static_cast<std::uint16_t>((static_cast<std::uint32_t>(a) * b) >> 16);
}

void box_mean(std::uint16_t* __restrict out, const std::uint16_t* __restrict whole, const std::uint16_t* __restrict low,
              const std::uint16_t* __restrict high, int shift, const std::uint16_t* __restrict scale_whole,
              const std::uint16_t* __restrict scale_ends, int count)
{
    for (int i = 0; i < count; ++i) {
        const auto ends = static_cast<std::uint16_t>((low[i] >> shift) + (high[i] >> shift));
        out[i] = static_cast<std::uint16_t>(high_product(whole[i], scale_whole[i]) + high_product(ends, scale_ends[i]));
    }
}

void box_mean_row(std::uint16_t* __restrict out, const std::uint16_t* __restrict whole,
                  const std::uint16_t* __restrict low, const std::uint16_t* __restrict high, int shift,
                  std::uint16_t scale_whole, std::uint16_t scale_ends, int count)
{
    for (int i = 0; i < count; ++i) {
        const auto ends = static_cast<std::uint16_t>((low[i] >> shift) + (high[i] >> shift));
        out[i] = static_cast<std::uint16_t>(high_product(whole[i], scale_whole) + high_product(ends, scale_ends));
    }
}

void store(std::uint8_t* __restrict out, const std::uint16_t* __restrict in, int count)
{
    for (int i = 0; i < count; ++i)
        out[i] = static_cast<std::uint8_t>((in[i] + 8) >> 4);
}

} // namespace

const SweepKernels LUMISWEEP_SWEEP_KERNELS = {LUMISWEEP_SWEEP_KERNELS_NAME,
                                              make_pairs,
                                              march,
                                              look_up,
                                              side_factors,
                                              to_visibility,
                                              add,
                                              slide,
                                              box_mean,
                                              box_mean_row,
                                              store};

} // namespace lumisweep

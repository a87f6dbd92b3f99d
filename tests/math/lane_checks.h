// Every function of math/lanes.h for arrays of inputs, by one lane type, into plain arrays: what lanes_test.cpp
// compares. No standard containers: compiled per instruction set.
#pragma once

#include <cstdint>

#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/math/random.h"
#include "lumisweep/math/stratified.h"
#include "lumisweep/math/trigonometry.h"

namespace lumisweep::test {

inline constexpr int lane_count = 1024;

/// Inputs of one run. Indices are in [0, table_size − 2].
struct LaneInput {
    static constexpr int table_size = 4096;
    float a[lane_count], b[lane_count], c[lane_count];
    float positive[lane_count]; ///< for log, sqrt
    float unit[lane_count];     ///< [0, 1]
    float eighth[lane_count];   ///< [−π/4, π/4]
    float oct_u[lane_count], oct_v[lane_count];
    std::int32_t i[lane_count], j[lane_count];
    std::int32_t on[lane_count]; ///< 0 or 1
    std::int32_t index[lane_count];
    float table_f32[table_size + 4];
    std::int32_t table_i32[table_size + 4];
    std::uint8_t table_u8[table_size + 4];
    std::uint16_t table_u16[table_size + 4];
    std::int16_t table_i16[table_size + 4];
};

enum FloatResult : int {
    f_select,
    f_add,
    f_subtract,
    f_multiply,
    f_divide,
    f_min,
    f_max,
    f_abs,
    f_sqrt,
    f_floor,
    f_copysign,
    f_to_float,
    f_as_float,
    f_load,
    f_gather,
    f_gather_small,
    f_pair_f32_0,
    f_pair_f32_1,
    f_pair_u8_0,
    f_pair_u8_1,
    f_pair_u16_0,
    f_pair_u16_1,
    f_pair_i16_0,
    f_pair_i16_1,
    f_random_a,
    f_random_b,
    f_random_c,
    f_stratified_a,
    f_stratified_b,
    f_stratified_c,
    // Up to here exactly as the scalar code; from here on within rounding.
    f_exact_count,
    f_fma = f_exact_count,
    f_reciprocal,
    f_log,
    f_exp,
    f_sin,
    f_cos,
    f_atan,
    f_direction_x,
    f_direction_y,
    f_direction_z,
    f_uv_u,
    f_uv_v,
    f_count
};
enum IntResult : int {
    i_select,
    i_add,
    i_subtract,
    i_multiply,
    i_and,
    i_or,
    i_xor,
    i_min,
    i_max,
    i_to_int,
    i_wrapping_mul,
    i_wrapping_add,
    i_shift_left,
    i_shift_right,
    i_shift_left_by,
    i_shift_right_by,
    i_as_int,
    i_load,
    i_gather,
    i_gather_u8,
    i_key_0,
    i_key_1,
    i_morton,
    i_morton_x,
    i_morton_y,
    i_less_float,
    i_less_equal,
    i_greater,
    i_greater_equal,
    i_equal,
    i_less_int,
    i_greater_int,
    i_equal_int,
    i_and_mask,
    i_or_mask,
    i_not_mask,
    i_of_bool,
    i_count
};

struct LaneOutput {
    float f[f_count][lane_count];
    std::int32_t i[i_count][lane_count];
    float packed_f[lane_count + 16];
    std::int32_t packed_i[lane_count + 16];
    int packed = 0;
    /// Of each group: bits, count, any, all, and the first n lanes for n from −1 to the width + 1.
    std::uint32_t bits[lane_count];
    int count[lane_count];
    bool any[lane_count], all[lane_count];
    std::uint32_t first[20];
};

template <class F>
inline __attribute__((always_inline)) void run_lanes(const LaneInput& in, LaneOutput& out)
{
    using I = int_of<F>;
    using M = mask_of<F>;
    constexpr int width = lane_width<F>;
    out.packed = 0;
    for (int n = -1; n <= width + 1; ++n)
        out.first[n + 1] = bits(first_lanes<F>(n));
    for (int at = 0; at < lane_count; at += width) {
        const F a = load<F>(in.a + at), b = load<F>(in.b + at), positive = load<F>(in.positive + at);
        const I i = load<F>(in.i + at), j = load<F>(in.j + at), index = load<F>(in.index + at);
        const M on = load<F>(in.on + at) == I(1), less = a < b;
        const auto put = [&](FloatResult r, const F& x) { store(out.f[r] + at, x); };
        const auto put_int = [&](IntResult r, const I& x) { store(out.i[r] + at, x); };
        const auto put_mask = [&](IntResult r, const M& m) { put_int(r, select(m, I(1), I(0))); };
        put(f_select, select(on, a, b)), put(f_add, a + b), put(f_subtract, a - b), put(f_multiply, a * b),
            put(f_divide, a / b);
        put(f_min, min(a, b)), put(f_max, max(a, b)), put(f_abs, abs(a)), put(f_sqrt, sqrt(positive)),
            put(f_floor, floor(a));
        put(f_copysign, copysign(a, b)), put(f_to_float, to_float(i)), put(f_as_float, as_float(i)), put(f_load, a);
        put(f_gather, gather(in.table_f32, index)), put(f_gather_small, gather_small(in.table_f32 + 5, index & I(15)));
        const Pair<F> f32 = gather_pair(in.table_f32, index), u8 = gather_pair(in.table_u8, index);
        const Pair<F> u16 = gather_pair(in.table_u16, index), i16 = gather_pair(in.table_i16, index);
        put(f_pair_f32_0, f32.first), put(f_pair_f32_1, f32.second), put(f_pair_u8_0, u8.first),
            put(f_pair_u8_1, u8.second);
        put(f_pair_u16_0, u16.first), put(f_pair_u16_1, u16.second), put(f_pair_i16_0, i16.first),
            put(f_pair_i16_1, i16.second);
        const Random3<F> random = random3(RandomKey<F>{i, j}, index);
        put(f_random_a, random.a), put(f_random_b, random.b), put(f_random_c, random.c);
        const Random3<F> stratified = stratified3(RandomKey<F>{i, j}, index, 2);
        put(f_stratified_a, stratified.a), put(f_stratified_b, stratified.b), put(f_stratified_c, stratified.c);
        put(f_fma, fma(a, b, load<F>(in.c + at))), put(f_reciprocal, reciprocal(positive)), put(f_log, log(positive));
        put(f_exp, exp(load<F>(in.unit + at) * F(-80.0F)));
        const SinCos<F> turn = sincos_eighth(load<F>(in.eighth + at));
        put(f_sin, turn.sin), put(f_cos, turn.cos), put(f_atan, atan_unit(load<F>(in.unit + at)));
        const Vec3<F> d = direction_from_oct(UV<F>{load<F>(in.oct_u + at), load<F>(in.oct_v + at)});
        const UV<F> uv = oct_from_direction(d);
        put(f_direction_x, d.x), put(f_direction_y, d.y), put(f_direction_z, d.z), put(f_uv_u, uv.u), put(f_uv_v, uv.v);

        put_int(i_select, select(on, i, j)), put_int(i_add, wrapping_add(i, j)), put_int(i_subtract, index - I(77));
        put_int(i_multiply, index * I(1000)), put_int(i_and, i & j), put_int(i_or, i | j), put_int(i_xor, i ^ j);
        put_int(i_min, min(i, j)), put_int(i_max, max(i, j)),
            put_int(i_to_int, to_int(select(abs(a) < F(2e9F), a, F(0.0F)))),
            put_int(i_wrapping_mul, wrapping_mul(i, j));
        put_int(i_wrapping_add, wrapping_add(i, j)), put_int(i_shift_left, shift_left<7>(i)),
            put_int(i_shift_right, shift_right<7>(i));
        put_int(i_shift_left_by, shift_left(i, at / 16 % 32)), put_int(i_shift_right_by, shift_right(i, at / 16 % 32));
        put_int(i_as_int, as_int(a)), put_int(i_load, i), put_int(i_gather, gather(in.table_i32, index)),
            put_int(i_gather_u8, gather(in.table_u8, index));
        const RandomKey<F> key = path_key<F>(index, 0x12345678, -77);
        put_int(i_key_0, key.k0), put_int(i_key_1, key.k1);
        const I morton = morton_encode(I(i & I(0x3fff)), I(j & I(0x3fff)));
        const TexelXY<I> xy = morton_decode(morton);
        put_int(i_morton, morton), put_int(i_morton_x, xy.x), put_int(i_morton_y, xy.y);
        put_mask(i_less_float, less), put_mask(i_less_equal, a <= b), put_mask(i_greater, a > b),
            put_mask(i_greater_equal, a >= b);
        put_mask(i_equal, a == b), put_mask(i_less_int, i < j), put_mask(i_greater_int, i > j),
            put_mask(i_equal_int, i == j);
        put_mask(i_and_mask, on & less), put_mask(i_or_mask, on | less), put_mask(i_not_mask, !on);
        put_mask(i_of_bool, (M(true) & on) | M(false));

        compress_store(out.packed_f + out.packed, on, a);
        compress_store(out.packed_i + out.packed, on, i);
        out.packed += count(on);
        const int group = at / width;
        out.bits[group] = bits(on), out.count[group] = count(on), out.any[group] = any(on), out.all[group] = all(on);
    }
}

void run_lanes_avx2(const LaneInput& in, LaneOutput& out);
void run_lanes_avx512(const LaneInput& in, LaneOutput& out);

} // namespace lumisweep::test

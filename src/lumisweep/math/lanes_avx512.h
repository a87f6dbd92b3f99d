// Sixteen float lanes on AVX-512 (F, DQ, BW, VL). Include only from files compiled with those flags (*_avx512.cpp).
#pragma once

#include <immintrin.h>

#include "lumisweep/math/lanes.h"

namespace lumisweep {

struct Avx512Mask {
    __mmask16 m;
    Avx512Mask() = default;
    LUMISWEEP_HD explicit Avx512Mask(__mmask16 bits) : m(bits) {}
    LUMISWEEP_HD explicit Avx512Mask(bool b) : m(static_cast<__mmask16>(b ? 0xffff : 0)) {}
    LUMISWEEP_HD friend Avx512Mask operator&(Avx512Mask a, Avx512Mask b) { return Avx512Mask(_kand_mask16(a.m, b.m)); }
    LUMISWEEP_HD friend Avx512Mask operator|(Avx512Mask a, Avx512Mask b) { return Avx512Mask(_kor_mask16(a.m, b.m)); }
    LUMISWEEP_HD friend Avx512Mask operator!(Avx512Mask a) { return Avx512Mask(_knot_mask16(a.m)); }
};

struct Avx512Int {
    __m512i v;
    Avx512Int() = default;
    LUMISWEEP_HD Avx512Int(__m512i x) : v(x) {}
    LUMISWEEP_HD explicit Avx512Int(std::int32_t x) : v(_mm512_set1_epi32(x)) {}
    LUMISWEEP_HD friend Avx512Int operator+(Avx512Int a, Avx512Int b) { return _mm512_add_epi32(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Int operator-(Avx512Int a, Avx512Int b) { return _mm512_sub_epi32(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Int operator*(Avx512Int a, Avx512Int b) { return _mm512_mullo_epi32(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Int operator&(Avx512Int a, Avx512Int b) { return _mm512_and_si512(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Int operator|(Avx512Int a, Avx512Int b) { return _mm512_or_si512(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Int operator^(Avx512Int a, Avx512Int b) { return _mm512_xor_si512(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Mask operator<(Avx512Int a, Avx512Int b)
    {
        return Avx512Mask(_mm512_cmplt_epi32_mask(a.v, b.v));
    }
    LUMISWEEP_HD friend Avx512Mask operator>(Avx512Int a, Avx512Int b) { return b < a; }
    LUMISWEEP_HD friend Avx512Mask operator==(Avx512Int a, Avx512Int b)
    {
        return Avx512Mask(_mm512_cmpeq_epi32_mask(a.v, b.v));
    }
};

struct Avx512Float {
    __m512 v;
    Avx512Float() = default;
    LUMISWEEP_HD Avx512Float(__m512 x) : v(x) {}
    LUMISWEEP_HD explicit Avx512Float(float x) : v(_mm512_set1_ps(x)) {}
    LUMISWEEP_HD explicit Avx512Float(double x) : Avx512Float(static_cast<float>(x)) {}
    LUMISWEEP_HD friend Avx512Float operator+(Avx512Float a, Avx512Float b) { return _mm512_add_ps(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Float operator-(Avx512Float a, Avx512Float b) { return _mm512_sub_ps(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Float operator*(Avx512Float a, Avx512Float b) { return _mm512_mul_ps(a.v, b.v); }
    LUMISWEEP_HD friend Avx512Float operator/(Avx512Float a, Avx512Float b) { return _mm512_div_ps(a.v, b.v); }
#define LUMISWEEP_COMPARE(op, code)                                                                                    \
    LUMISWEEP_HD friend Avx512Mask operator op(Avx512Float a, Avx512Float b)                                           \
    {                                                                                                                  \
        return Avx512Mask(_mm512_cmp_ps_mask(a.v, b.v, code));                                                         \
    }
    LUMISWEEP_COMPARE(<, _CMP_LT_OQ)
    LUMISWEEP_COMPARE(<=, _CMP_LE_OQ)
    LUMISWEEP_COMPARE(>, _CMP_GT_OQ)
    LUMISWEEP_COMPARE(>=, _CMP_GE_OQ)
    LUMISWEEP_COMPARE(==, _CMP_EQ_OQ)
#undef LUMISWEEP_COMPARE
};

template <>
struct LaneTraits<Avx512Float> {
    using Int = Avx512Int;
    using Mask = Avx512Mask;
    static constexpr int width = 16;
};

LUMISWEEP_HD Avx512Float select(Avx512Mask m, Avx512Float a, Avx512Float b)
{
    return _mm512_mask_blend_ps(m.m, b.v, a.v);
}
LUMISWEEP_HD Avx512Int select(Avx512Mask m, Avx512Int a, Avx512Int b) { return _mm512_mask_blend_epi32(m.m, b.v, a.v); }
LUMISWEEP_HD bool any(Avx512Mask m) { return m.m != 0; }
LUMISWEEP_HD bool all(Avx512Mask m) { return m.m == 0xffff; }
LUMISWEEP_HD int count(Avx512Mask m) { return __builtin_popcount(m.m); }
LUMISWEEP_HD std::uint32_t bits(Avx512Mask m) { return m.m; }
template <>
LUMISWEEP_HD Avx512Mask first_lanes<Avx512Float>(int n)
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    return Avx512Mask(_mm512_cmplt_epi32_mask(lane, _mm512_set1_epi32(n)));
}

LUMISWEEP_HD Avx512Float min(Avx512Float a, Avx512Float b) { return _mm512_min_ps(b.v, a.v); }
LUMISWEEP_HD Avx512Float max(Avx512Float a, Avx512Float b) { return _mm512_max_ps(b.v, a.v); }
LUMISWEEP_HD Avx512Int min(Avx512Int a, Avx512Int b) { return _mm512_min_epi32(a.v, b.v); }
LUMISWEEP_HD Avx512Int max(Avx512Int a, Avx512Int b) { return _mm512_max_epi32(a.v, b.v); }
LUMISWEEP_HD Avx512Float abs(Avx512Float a) { return _mm512_abs_ps(a.v); }
/// An estimate of 14 bits and one step of Newton's iteration: a division takes several times as long.
LUMISWEEP_HD Avx512Float reciprocal(Avx512Float a)
{
    const __m512 estimate = _mm512_rcp14_ps(a.v);
    return _mm512_fmadd_ps(_mm512_fnmadd_ps(a.v, estimate, _mm512_set1_ps(1.0F)), estimate, estimate);
}
LUMISWEEP_HD Avx512Float sqrt(Avx512Float a) { return _mm512_sqrt_ps(a.v); }
LUMISWEEP_HD Avx512Float floor(Avx512Float a)
{
    return _mm512_roundscale_ps(a.v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}
LUMISWEEP_HD Avx512Float copysign(Avx512Float magnitude, Avx512Float sign)
{
    const __m512 mask = _mm512_set1_ps(-0.0F);
    return _mm512_or_ps(_mm512_andnot_ps(mask, magnitude.v), _mm512_and_ps(mask, sign.v));
}
LUMISWEEP_HD Avx512Float fma(Avx512Float a, Avx512Float b, Avx512Float c) { return _mm512_fmadd_ps(a.v, b.v, c.v); }

LUMISWEEP_HD Avx512Int to_int(Avx512Float a) { return _mm512_cvttps_epi32(a.v); }
LUMISWEEP_HD Avx512Float to_float(Avx512Int a) { return _mm512_cvtepi32_ps(a.v); }
LUMISWEEP_HD Avx512Int as_int(Avx512Float a) { return _mm512_castps_si512(a.v); }
LUMISWEEP_HD Avx512Float as_float(Avx512Int a) { return _mm512_castsi512_ps(a.v); }
LUMISWEEP_HD Avx512Int wrapping_mul(Avx512Int a, Avx512Int b) { return a * b; }
LUMISWEEP_HD Avx512Int wrapping_add(Avx512Int a, Avx512Int b) { return a + b; }
template <int Shift>
LUMISWEEP_HD Avx512Int shift_left(Avx512Int a)
{
    return _mm512_slli_epi32(a.v, Shift);
}
template <int Shift>
LUMISWEEP_HD Avx512Int shift_right(Avx512Int a)
{
    return _mm512_srli_epi32(a.v, Shift);
}
LUMISWEEP_HD Avx512Int shift_left(Avx512Int a, int by) { return _mm512_sll_epi32(a.v, _mm_cvtsi32_si128(by)); }
LUMISWEEP_HD Avx512Int shift_right(Avx512Int a, int by) { return _mm512_srl_epi32(a.v, _mm_cvtsi32_si128(by)); }
LUMISWEEP_HD Avx512Float log(Avx512Float a) { return log_polynomial(a); }
LUMISWEEP_HD Avx512Float exp(Avx512Float a) { return exp_polynomial(a); }

template <>
LUMISWEEP_HD Avx512Float load<Avx512Float>(const float* p)
{
    return _mm512_loadu_ps(p);
}
template <>
LUMISWEEP_HD Avx512Int load<Avx512Float>(const std::int32_t* p)
{
    return _mm512_loadu_si512(p);
}
LUMISWEEP_HD void store(float* p, Avx512Float a) { _mm512_storeu_ps(p, a.v); }
LUMISWEEP_HD void store(std::int32_t* p, Avx512Int a) { _mm512_storeu_si512(p, a.v); }
LUMISWEEP_HD void compress_store(float* p, Avx512Mask m, Avx512Float a)
{
    _mm512_storeu_ps(p, _mm512_maskz_compress_ps(m.m, a.v));
}
LUMISWEEP_HD void compress_store(std::int32_t* p, Avx512Mask m, Avx512Int a)
{
    _mm512_storeu_si512(p, _mm512_maskz_compress_epi32(m.m, a.v));
}
LUMISWEEP_HD Avx512Float gather(const float* base, Avx512Int index) { return _mm512_i32gather_ps(index.v, base, 4); }
LUMISWEEP_HD Avx512Int gather(const std::int32_t* base, Avx512Int index)
{
    return _mm512_i32gather_epi32(index.v, base, 4);
}
LUMISWEEP_HD Avx512Int gather(const std::uint8_t* base, Avx512Int index)
{
    return _mm512_and_si512(_mm512_i32gather_epi32(index.v, base, 1), _mm512_set1_epi32(0xff));
}

LUMISWEEP_HD Avx512Float gather_small(const float* base, Avx512Int index)
{
    return _mm512_permutexvar_ps(index.v, _mm512_loadu_ps(base));
}

LUMISWEEP_HD Pair<Avx512Float> gather_pair(const float* base, Avx512Int index)
{
    return {gather(base, index), gather(base + 1, index)};
}
LUMISWEEP_HD Pair<Avx512Float> gather_pair(const std::uint8_t* base, Avx512Int index)
{
    const __m512i word = _mm512_i32gather_epi32(index.v, base, 1);
    const __m512i byte = _mm512_set1_epi32(0xff);
    return {_mm512_cvtepi32_ps(_mm512_and_si512(word, byte)),
            _mm512_cvtepi32_ps(_mm512_and_si512(_mm512_srli_epi32(word, 8), byte))};
}
LUMISWEEP_HD Pair<Avx512Float> gather_pair(const std::uint16_t* base, Avx512Int index)
{
    const __m512i word = _mm512_i32gather_epi32(index.v, base, 2);
    return {_mm512_cvtepi32_ps(_mm512_and_si512(word, _mm512_set1_epi32(0xffff))),
            _mm512_cvtepi32_ps(_mm512_srli_epi32(word, 16))};
}
LUMISWEEP_HD Pair<Avx512Float> gather_pair(const std::int16_t* base, Avx512Int index)
{
    const __m512i word = _mm512_i32gather_epi32(index.v, base, 2);
    return {_mm512_cvtepi32_ps(_mm512_srai_epi32(_mm512_slli_epi32(word, 16), 16)),
            _mm512_cvtepi32_ps(_mm512_srai_epi32(word, 16))};
}

} // namespace lumisweep

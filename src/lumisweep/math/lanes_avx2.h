// Eight float lanes on AVX2 with FMA. Include only from files compiled with those flags (*_avx2.cpp).
#pragma once

#include <immintrin.h>

#include "lumisweep/math/lanes.h"

namespace lumisweep {

/// Each lane all ones or all zeros.
struct Avx2Mask {
    __m256 m;
    Avx2Mask() = default;
    LUMISWEEP_HD explicit Avx2Mask(__m256 x) : m(x) {}
    LUMISWEEP_HD explicit Avx2Mask(__m256i x) : m(_mm256_castsi256_ps(x)) {}
    LUMISWEEP_HD explicit Avx2Mask(bool b) : m(_mm256_castsi256_ps(_mm256_set1_epi32(b ? -1 : 0))) {}
    LUMISWEEP_HD friend Avx2Mask operator&(Avx2Mask a, Avx2Mask b) { return Avx2Mask(_mm256_and_ps(a.m, b.m)); }
    LUMISWEEP_HD friend Avx2Mask operator|(Avx2Mask a, Avx2Mask b) { return Avx2Mask(_mm256_or_ps(a.m, b.m)); }
    LUMISWEEP_HD friend Avx2Mask operator!(Avx2Mask a)
    {
        return Avx2Mask(_mm256_xor_ps(a.m, _mm256_castsi256_ps(_mm256_set1_epi32(-1))));
    }
};

struct Avx2Int {
    __m256i v;
    Avx2Int() = default;
    LUMISWEEP_HD Avx2Int(__m256i x) : v(x) {}
    LUMISWEEP_HD explicit Avx2Int(std::int32_t x) : v(_mm256_set1_epi32(x)) {}
    LUMISWEEP_HD friend Avx2Int operator+(Avx2Int a, Avx2Int b) { return _mm256_add_epi32(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Int operator-(Avx2Int a, Avx2Int b) { return _mm256_sub_epi32(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Int operator*(Avx2Int a, Avx2Int b) { return _mm256_mullo_epi32(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Int operator&(Avx2Int a, Avx2Int b) { return _mm256_and_si256(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Int operator|(Avx2Int a, Avx2Int b) { return _mm256_or_si256(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Int operator^(Avx2Int a, Avx2Int b) { return _mm256_xor_si256(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Mask operator<(Avx2Int a, Avx2Int b) { return Avx2Mask(_mm256_cmpgt_epi32(b.v, a.v)); }
    LUMISWEEP_HD friend Avx2Mask operator>(Avx2Int a, Avx2Int b) { return Avx2Mask(_mm256_cmpgt_epi32(a.v, b.v)); }
    LUMISWEEP_HD friend Avx2Mask operator==(Avx2Int a, Avx2Int b) { return Avx2Mask(_mm256_cmpeq_epi32(a.v, b.v)); }
};

struct Avx2Float {
    __m256 v;
    Avx2Float() = default;
    LUMISWEEP_HD Avx2Float(__m256 x) : v(x) {}
    LUMISWEEP_HD explicit Avx2Float(float x) : v(_mm256_set1_ps(x)) {}
    LUMISWEEP_HD explicit Avx2Float(double x) : Avx2Float(static_cast<float>(x)) {}
    LUMISWEEP_HD friend Avx2Float operator+(Avx2Float a, Avx2Float b) { return _mm256_add_ps(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Float operator-(Avx2Float a, Avx2Float b) { return _mm256_sub_ps(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Float operator*(Avx2Float a, Avx2Float b) { return _mm256_mul_ps(a.v, b.v); }
    LUMISWEEP_HD friend Avx2Float operator/(Avx2Float a, Avx2Float b) { return _mm256_div_ps(a.v, b.v); }
#define LUMISWEEP_COMPARE(op, code)                                                                                    \
    LUMISWEEP_HD friend Avx2Mask operator op(Avx2Float a, Avx2Float b)                                                 \
    {                                                                                                                  \
        return Avx2Mask(_mm256_cmp_ps(a.v, b.v, code));                                                                \
    }
    LUMISWEEP_COMPARE(<, _CMP_LT_OQ)
    LUMISWEEP_COMPARE(<=, _CMP_LE_OQ)
    LUMISWEEP_COMPARE(>, _CMP_GT_OQ)
    LUMISWEEP_COMPARE(>=, _CMP_GE_OQ)
    LUMISWEEP_COMPARE(==, _CMP_EQ_OQ)
#undef LUMISWEEP_COMPARE
};

template <>
struct LaneTraits<Avx2Float> {
    using Int = Avx2Int;
    using Mask = Avx2Mask;
    static constexpr int width = 8;
};

LUMISWEEP_HD Avx2Float select(Avx2Mask m, Avx2Float a, Avx2Float b) { return _mm256_blendv_ps(b.v, a.v, m.m); }
LUMISWEEP_HD Avx2Int select(Avx2Mask m, Avx2Int a, Avx2Int b)
{
    return _mm256_blendv_epi8(b.v, a.v, _mm256_castps_si256(m.m));
}
LUMISWEEP_HD std::uint32_t bits(Avx2Mask m) { return static_cast<std::uint32_t>(_mm256_movemask_ps(m.m)); }
LUMISWEEP_HD bool any(Avx2Mask m) { return bits(m) != 0; }
LUMISWEEP_HD bool all(Avx2Mask m) { return bits(m) == 0xff; }
LUMISWEEP_HD int count(Avx2Mask m) { return __builtin_popcount(bits(m)); }
template <>
LUMISWEEP_HD Avx2Mask first_lanes<Avx2Float>(int n)
{
    return Avx2Mask(_mm256_cmpgt_epi32(_mm256_set1_epi32(n), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)));
}

LUMISWEEP_HD Avx2Float min(Avx2Float a, Avx2Float b) { return _mm256_min_ps(b.v, a.v); }
LUMISWEEP_HD Avx2Float max(Avx2Float a, Avx2Float b) { return _mm256_max_ps(b.v, a.v); }
LUMISWEEP_HD Avx2Int min(Avx2Int a, Avx2Int b) { return _mm256_min_epi32(a.v, b.v); }
LUMISWEEP_HD Avx2Int max(Avx2Int a, Avx2Int b) { return _mm256_max_epi32(a.v, b.v); }
LUMISWEEP_HD Avx2Float abs(Avx2Float a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a.v); }
LUMISWEEP_HD Avx2Float reciprocal(Avx2Float a) { return _mm256_div_ps(_mm256_set1_ps(1.0F), a.v); }
LUMISWEEP_HD Avx2Float sqrt(Avx2Float a) { return _mm256_sqrt_ps(a.v); }
LUMISWEEP_HD Avx2Float floor(Avx2Float a) { return _mm256_floor_ps(a.v); }
LUMISWEEP_HD Avx2Float copysign(Avx2Float magnitude, Avx2Float sign)
{
    const __m256 mask = _mm256_set1_ps(-0.0F);
    return _mm256_or_ps(_mm256_andnot_ps(mask, magnitude.v), _mm256_and_ps(mask, sign.v));
}
LUMISWEEP_HD Avx2Float fma(Avx2Float a, Avx2Float b, Avx2Float c) { return _mm256_fmadd_ps(a.v, b.v, c.v); }

LUMISWEEP_HD Avx2Int to_int(Avx2Float a) { return _mm256_cvttps_epi32(a.v); }
LUMISWEEP_HD Avx2Float to_float(Avx2Int a) { return _mm256_cvtepi32_ps(a.v); }
LUMISWEEP_HD Avx2Int as_int(Avx2Float a) { return _mm256_castps_si256(a.v); }
LUMISWEEP_HD Avx2Float as_float(Avx2Int a) { return _mm256_castsi256_ps(a.v); }
LUMISWEEP_HD Avx2Int wrapping_mul(Avx2Int a, Avx2Int b) { return a * b; }
LUMISWEEP_HD Avx2Int wrapping_add(Avx2Int a, Avx2Int b) { return a + b; }
template <int Shift>
LUMISWEEP_HD Avx2Int shift_left(Avx2Int a)
{
    return _mm256_slli_epi32(a.v, Shift);
}
template <int Shift>
LUMISWEEP_HD Avx2Int shift_right(Avx2Int a)
{
    return _mm256_srli_epi32(a.v, Shift);
}
LUMISWEEP_HD Avx2Int shift_left(Avx2Int a, int by) { return _mm256_sll_epi32(a.v, _mm_cvtsi32_si128(by)); }
LUMISWEEP_HD Avx2Int shift_right(Avx2Int a, int by) { return _mm256_srl_epi32(a.v, _mm_cvtsi32_si128(by)); }
LUMISWEEP_HD Avx2Float log(Avx2Float a) { return log_polynomial(a); }
LUMISWEEP_HD Avx2Float exp(Avx2Float a) { return exp_polynomial(a); }

template <>
LUMISWEEP_HD Avx2Float load<Avx2Float>(const float* p)
{
    return _mm256_loadu_ps(p);
}
template <>
LUMISWEEP_HD Avx2Int load<Avx2Float>(const std::int32_t* p)
{
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
LUMISWEEP_HD void store(float* p, Avx2Float a) { _mm256_storeu_ps(p, a.v); }
LUMISWEEP_HD void store(std::int32_t* p, Avx2Int a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v); }

/// The lane numbers that are on, packed, one byte each: a deposit of bytes, then an extraction (BMI2).
LUMISWEEP_HD Avx2Int compress_order(Avx2Mask m)
{
    const std::uint64_t on = _pdep_u64(bits(m), 0x0101010101010101ULL) * 0xffU;
    const std::uint64_t order = _pext_u64(0x0706050403020100ULL, on);
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(order)));
}
LUMISWEEP_HD void compress_store(float* p, Avx2Mask m, Avx2Float a)
{
    store(p, Avx2Float(_mm256_permutevar8x32_ps(a.v, compress_order(m).v)));
}
LUMISWEEP_HD void compress_store(std::int32_t* p, Avx2Mask m, Avx2Int a)
{
    store(p, Avx2Int(_mm256_permutevar8x32_epi32(a.v, compress_order(m).v)));
}
LUMISWEEP_HD Avx2Float gather(const float* base, Avx2Int index) { return _mm256_i32gather_ps(base, index.v, 4); }
LUMISWEEP_HD Avx2Int gather(const std::int32_t* base, Avx2Int index)
{
    return _mm256_i32gather_epi32(base, index.v, 4);
}
LUMISWEEP_HD Avx2Int gather(const std::uint8_t* base, Avx2Int index)
{
    return _mm256_and_si256(_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), index.v, 1),
                            _mm256_set1_epi32(0xff));
}

LUMISWEEP_HD Avx2Float gather_small(const float* base, Avx2Int index)
{
    const __m256 low = _mm256_permutevar8x32_ps(_mm256_loadu_ps(base), index.v);
    const __m256 high = _mm256_permutevar8x32_ps(_mm256_loadu_ps(base + 8), index.v);
    // Bit 3 of the index chooses by the sign.
    return _mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32(index.v, 28)));
}

LUMISWEEP_HD Pair<Avx2Float> gather_pair(const float* base, Avx2Int index)
{
    return {gather(base, index), gather(base + 1, index)};
}
LUMISWEEP_HD Pair<Avx2Float> gather_pair(const std::uint8_t* base, Avx2Int index)
{
    const __m256i word = _mm256_i32gather_epi32(reinterpret_cast<const int*>(base), index.v, 1);
    const __m256i byte = _mm256_set1_epi32(0xff);
    return {_mm256_cvtepi32_ps(_mm256_and_si256(word, byte)),
            _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(word, 8), byte))};
}
LUMISWEEP_HD Pair<Avx2Float> gather_pair(const std::uint16_t* base, Avx2Int index)
{
    const __m256i word = _mm256_i32gather_epi32(reinterpret_cast<const int*>(base), index.v, 2);
    return {_mm256_cvtepi32_ps(_mm256_and_si256(word, _mm256_set1_epi32(0xffff))),
            _mm256_cvtepi32_ps(_mm256_srli_epi32(word, 16))};
}
LUMISWEEP_HD Pair<Avx2Float> gather_pair(const std::int16_t* base, Avx2Int index)
{
    const __m256i word = _mm256_i32gather_epi32(reinterpret_cast<const int*>(base), index.v, 2);
    return {_mm256_cvtepi32_ps(_mm256_srai_epi32(_mm256_slli_epi32(word, 16), 16)),
            _mm256_cvtepi32_ps(_mm256_srai_epi32(word, 16))};
}

} // namespace lumisweep

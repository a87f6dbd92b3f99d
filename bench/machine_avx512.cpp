#if defined(__x86_64__)
#include <immintrin.h>

#include "machine.h"

namespace lumisweep::bench {
namespace {

std::uint64_t read(const std::uint8_t* p, std::size_t bytes, int passes)
{
    __m512i a[8];
    for (__m512i& x : a)
        x = _mm512_setzero_si512();
    for (int pass = 0; pass < passes; ++pass) {
        for (const std::uint8_t* q = p; q < p + bytes; q += 512)
            for (int i = 0; i < 8; ++i)
                a[i] = _mm512_or_si512(a[i], _mm512_loadu_si512(q + 64 * i));
        asm volatile("" ::: "memory");
    }
    for (int i = 1; i < 8; ++i)
        a[0] = _mm512_or_si512(a[0], a[i]);
    return static_cast<std::uint64_t>(_mm512_reduce_or_epi64(a[0]));
}

void stream(std::uint8_t* p, std::size_t bytes)
{
    const __m512i value = _mm512_set1_epi8(5);
    for (std::uint8_t* q = p; q < p + bytes; q += 64)
        _mm512_stream_si512(reinterpret_cast<__m512i*>(q), value);
    _mm_sfence();
}

constexpr int chains = 12; // independent sums: more than latency × issue ports

std::uint32_t dot_without_vnni(std::int64_t rounds)
{
    __m512i sums[chains];
    for (__m512i& s : sums)
        s = _mm512_setzero_si512();
    __m512i voxels = _mm512_set1_epi8(3), weights = _mm512_set1_epi8(2), ones = _mm512_set1_epi16(1);
    for (std::int64_t round = 0; round < rounds; ++round) {
        asm volatile("" : "+v"(voxels), "+v"(weights), "+v"(ones));
        for (__m512i& s : sums) {
            __m512i pairs = _mm512_maddubs_epi16(voxels, weights);
            asm volatile("" : "+v"(pairs)); // else the chains would share one product
            s = _mm512_add_epi32(s, _mm512_madd_epi16(pairs, ones));
        }
    }
    for (int i = 1; i < chains; ++i)
        sums[0] = _mm512_add_epi32(sums[0], sums[i]);
    return static_cast<std::uint32_t>(_mm512_reduce_add_epi32(sums[0]));
}

__attribute__((target("avx512vnni"))) std::uint32_t dot_vnni(std::int64_t rounds)
{
    __m512i sums[chains];
    for (__m512i& s : sums)
        s = _mm512_setzero_si512();
    __m512i voxels = _mm512_set1_epi8(3), weights = _mm512_set1_epi8(2);
    for (std::int64_t round = 0; round < rounds; ++round) {
        asm volatile("" : "+v"(voxels), "+v"(weights));
        for (__m512i& s : sums)
            s = _mm512_dpbusd_epi32(s, voxels, weights);
    }
    for (int i = 1; i < chains; ++i)
        sums[0] = _mm512_add_epi32(sums[0], sums[i]);
    return static_cast<std::uint32_t>(_mm512_reduce_add_epi32(sums[0]));
}

float fma(std::int64_t rounds)
{
    __m512 sums[chains];
    for (__m512& s : sums)
        s = _mm512_setzero_ps();
    __m512 a = _mm512_set1_ps(0.5F), b = _mm512_set1_ps(0.25F);
    for (std::int64_t round = 0; round < rounds; ++round) {
        asm volatile("" : "+v"(a), "+v"(b));
        for (__m512& s : sums)
            s = _mm512_fmadd_ps(s, a, b);
    }
    for (int i = 1; i < chains; ++i)
        sums[0] = _mm512_add_ps(sums[0], sums[i]);
    return _mm512_reduce_add_ps(sums[0]);
}

} // namespace

const MachineKernels machine_avx512 = {
    "avx512", "VPMADDUBSW, VPMADDWD, VPADDD", read, stream, dot_without_vnni, 16 * chains, fma, 32 * chains};
const MachineKernels machine_avx512_vnni = {"avx512-vnni", "VPDPBUSD",  read, stream,
                                            dot_vnni,      16 * chains, fma,  32 * chains};

} // namespace lumisweep::bench
#endif

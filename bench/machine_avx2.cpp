#if defined(__x86_64__)
#include <immintrin.h>

#include "machine.h"

namespace lumisweep::bench {
namespace {

std::uint64_t read(const std::uint8_t* p, std::size_t bytes, int passes)
{
    __m256i a[8];
    for (__m256i& x : a)
        x = _mm256_setzero_si256();
    for (int pass = 0; pass < passes; ++pass) {
        for (const std::uint8_t* q = p; q < p + bytes; q += 256)
            for (int i = 0; i < 8; ++i)
                a[i] = _mm256_or_si256(a[i], _mm256_loadu_si256(reinterpret_cast<const __m256i*>(q + 32 * i)));
        asm volatile("" ::: "memory");
    }
    for (int i = 1; i < 8; ++i)
        a[0] = _mm256_or_si256(a[0], a[i]);
    return static_cast<std::uint64_t>(_mm256_extract_epi64(a[0], 0) | _mm256_extract_epi64(a[0], 1) |
                                      _mm256_extract_epi64(a[0], 2) | _mm256_extract_epi64(a[0], 3));
}

void stream(std::uint8_t* p, std::size_t bytes)
{
    const __m256i value = _mm256_set1_epi8(5);
    for (std::uint8_t* q = p; q < p + bytes; q += 32)
        _mm256_stream_si256(reinterpret_cast<__m256i*>(q), value);
    _mm_sfence();
}

constexpr int chains = 10; // independent sums: more than latency × issue ports

std::uint32_t dot(std::int64_t rounds)
{
    __m256i sums[chains];
    for (__m256i& s : sums)
        s = _mm256_setzero_si256();
    __m256i voxels = _mm256_set1_epi8(3), weights = _mm256_set1_epi8(2), ones = _mm256_set1_epi16(1);
    for (std::int64_t round = 0; round < rounds; ++round) {
        asm volatile("" : "+x"(voxels), "+x"(weights), "+x"(ones));
        for (__m256i& s : sums) {
            __m256i pairs = _mm256_maddubs_epi16(voxels, weights);
            asm volatile("" : "+x"(pairs)); // else the chains would share one product
            s = _mm256_add_epi32(s, _mm256_madd_epi16(pairs, ones));
        }
    }
    for (int i = 1; i < chains; ++i)
        sums[0] = _mm256_add_epi32(sums[0], sums[i]);
    return static_cast<std::uint32_t>(_mm256_extract_epi32(sums[0], 0));
}

float fma(std::int64_t rounds)
{
    __m256 sums[chains];
    for (__m256& s : sums)
        s = _mm256_setzero_ps();
    __m256 a = _mm256_set1_ps(0.5F), b = _mm256_set1_ps(0.25F);
    for (std::int64_t round = 0; round < rounds; ++round) {
        asm volatile("" : "+x"(a), "+x"(b));
        for (__m256& s : sums)
            s = _mm256_fmadd_ps(s, a, b);
    }
    for (int i = 1; i < chains; ++i)
        sums[0] = _mm256_add_ps(sums[0], sums[i]);
    return _mm256_cvtss_f32(sums[0]);
}

} // namespace

const MachineKernels machine_avx2 = {"avx2",     "VPMADDUBSW, VPMADDWD, VPADDD", read, stream, dot, 8 * chains, fma,
                                     16 * chains};

} // namespace lumisweep::bench
#endif

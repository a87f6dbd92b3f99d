// sample_direction and direction_pdf_uv for arrays of inputs, by one lane type. No standard containers: compiled per
// instruction set.
#pragma once

#include <cstdint>

#include "lumisweep/sampling/direction_sampling.h"

namespace lumisweep::test {

/// Structure-of-arrays, a multiple of 16 entries.
struct LaneSamples {
    int count = 0;
    const float *px = nullptr, *py = nullptr, *pz = nullptr; ///< p_voxel
    const float *a = nullptr, *b = nullptr, *c = nullptr;    ///< uniform numbers
    float *u = nullptr, *v = nullptr, *pdf_uv = nullptr, *pdf_again = nullptr;
    std::int32_t* texel = nullptr;
};

template <class F>
inline __attribute__((always_inline)) void sample_lanes(const DirectionSamplingView& view, const LaneSamples& s)
{
    for (int i = 0; i < s.count; i += lane_width<F>) {
        const Vec3<F> p{load<F>(s.px + i), load<F>(s.py + i), load<F>(s.pz + i)};
        const DirectionSample<F> sample =
            sample_direction(view, p, Random3<F>{load<F>(s.a + i), load<F>(s.b + i), load<F>(s.c + i)});
        store(s.u + i, sample.uv_oct.u), store(s.v + i, sample.uv_oct.v), store(s.pdf_uv + i, sample.pdf_uv);
        store(s.texel + i, sample.texel);
        store(s.pdf_again + i, direction_pdf_uv(view, p, sample.uv_oct));
    }
}

void sample_lanes_avx2(const DirectionSamplingView& view, const LaneSamples& samples);
void sample_lanes_avx512(const DirectionSamplingView& view, const LaneSamples& samples);

} // namespace lumisweep::test

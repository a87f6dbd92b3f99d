// Drawing samples on the device: a persistent loop over the path stages, one thread a path.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/render/film_sums.h"
#include "lumisweep/render/pass.h"
#include "lumisweep/render/scene_view.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Samples of every pixel that are drawn by one launch at most.
inline constexpr int most_samples_a_batch = 32;

/// Memory: color [sample][pixel][3], features [sample][pixel][feature_count] float, of which a path writes its own.
struct SampleBatch {
    float* color = nullptr;
    float* features = nullptr;
    int width = 0, height = 0;
    PassNumbers pass[most_samples_a_batch] = {}; ///< [sample]

    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    /// Numbers that one sample's paths have: pixels in squares of 8 × 8, some beyond the image.
    std::uint32_t numbers_a_sample() const
    {
        return static_cast<std::uint32_t>((width + 7) / 8) * static_cast<std::uint32_t>((height + 7) / 8) * 64U;
    }
};

/// What threads add to while they draw: PassCounts by kind.
struct PathCounters {
    enum Kind { paths, shadow_rays, camera_steps, shadow_steps, advance_steps, advance_lanes, candidate_lanes, kinds };

    std::uint64_t of[kinds] = {};
    std::uint32_t next = 0; ///< paths begun in this launch
    std::uint32_t unused = 0;
};

/// Whether this build has code for the device.
bool can_draw_paths();

/// Draws the paths with numbers [begin, end), sample by sample. `counters` are in the device's memory. Which thread
/// draws a path depends on the moment, what it brings does not.
void draw_paths(const SceneView& scene, const SampleBatch& batch, std::uint32_t begin, std::uint32_t end,
                PathCounters* counters, int multiprocessors, const Stream& stream);

/// Adds samples 0 … count − 1 of a batch to the film's sums, in order; the first is number `first_sample` of its film.
void add_to_film(const FilmSums& film, const SampleBatch& batch, int count, std::int64_t first_sample,
                 const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA

// Passes on their way: the film's sums in the device's memory, and the samples that are being drawn for it.
#pragma once

#include <atomic>
#include <cstdint>

#include "lumisweep/backends/cuda/draw_paths.h"
#include "lumisweep/backends/cuda/staged_copy.h"
#include "lumisweep/render/film.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Draws passes in batches, so that a small image keeps the device busy, too, and waits only when two batches are
/// under way. Batches are added to the sums in their order, so sums repeat to the bit, however passes are batched.
class PassQueue {
public:
    explicit PassQueue(int multiprocessors);

    /// An empty film of that size; passes that are not in the sums yet are given up. Memory is taken with the next
    /// pass.
    void clear(int width, int height);
    void restore(const FilmArrays& arrays, const Stream& stream);

    /// Takes up a pass; of a large image it is drawn before this returns, and cancelled as a whole when *cancel becomes
    /// true in between. `scene` points to the device's memory and stays the same until clear() or draw_pending().
    PassEnd take(const SceneView& scene, std::int64_t sample, const std::atomic<bool>* cancel, const Stream& stream);
    /// Begins to draw what has been taken up.
    void draw_pending(const Stream& stream);

    /// Draws what has been taken up, waits, and copies the sums.
    void fetch(FilmArrays& arrays, const Stream& stream);
    /// Of all passes that were drawn, and of parts of those that were cancelled; draws and waits likewise.
    PassCounts counts(const Stream& stream);

    std::uint64_t bytes() const;
    static std::uint64_t bytes_needed(int width, int height, int multiprocessors);
    int multiprocessors() const { return multiprocessors_; }

private:
    FilmSums sums();
    void take_memory(const Stream& stream);
    PassEnd draw(const std::atomic<bool>* cancel, const Stream& stream);
    void keep_two_launches(const Stream& stream);

    int multiprocessors_;
    std::uint32_t paths_a_launch_;
    bool empty_ = true; ///< the sums have no memory, or that of a film before
    DeviceArray<double> color_sum_, color_sum_squares_, block_sum_squares_, block_begin_;
    DeviceArray<float> features_;
    DeviceArray<float> sample_color_, sample_features_;
    DeviceArray<PathCounters> counters_;
    SceneView scene_;
    SampleBatch batch_;
    int batch_size_ = 1;             ///< passes
    int pending_ = 0;                ///< passes taken up and not yet drawn
    std::int64_t first_pending_ = 0; ///< number of the first of them
    Event launched_[2];
    unsigned launches_ = 0;
    StagedCopy copy_;
};

} // namespace lumisweep::LUMISWEEP_CUDA

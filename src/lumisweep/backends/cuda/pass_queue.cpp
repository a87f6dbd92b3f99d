#include "lumisweep/backends/cuda/pass_queue.h"

#include <algorithm>
#include <utility>

#include "lumisweep/base/cancelled.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

/// Paths of a launch, for each multiprocessor: enough that the last of them, which leave the device half empty, weigh
/// little, and some milliseconds, for which a cancelled pass goes on.
constexpr std::uint32_t paths_a_multiprocessor = 1U << 15;

std::uint32_t launch_of(int multiprocessors)
{
    return static_cast<std::uint32_t>(multiprocessors) * paths_a_multiprocessor;
}

int batch_of(std::uint32_t numbers_a_sample, std::uint32_t paths_a_launch)
{
    return std::clamp(static_cast<int>(paths_a_launch / numbers_a_sample), 1, most_samples_a_batch);
}

} // namespace

PassQueue::PassQueue(int multiprocessors)
    : multiprocessors_(multiprocessors), paths_a_launch_(launch_of(multiprocessors))
{
}

void PassQueue::clear(int width, int height)
{
    pending_ = 0;
    empty_ = true;
    batch_.width = width;
    batch_.height = height;
}

void PassQueue::take_memory(const Stream& stream)
{
    batch_size_ = batch_of(batch_.numbers_a_sample(), paths_a_launch_);
    const std::size_t pixels = batch_.pixels(), samples = pixels * static_cast<std::size_t>(batch_size_);
    constexpr const char *film = "the film", *batch = "samples of a batch of passes";
    for (DeviceArray<double>* sum : {&color_sum_, &color_sum_squares_, &block_sum_squares_, &block_begin_})
        sum->resize(3 * pixels, film);
    features_.resize(feature_count * pixels, film);
    sample_color_.resize(3 * samples, batch);
    sample_features_.resize(feature_count * samples, batch);
    batch_.color = sample_color_.data();
    batch_.features = sample_features_.data();
    if (counters_.empty()) {
        counters_.resize(1, "counters");
        fill_on_device(counters_.data(), 0, counters_.bytes(), stream);
    }
}

void PassQueue::restore(const FilmArrays& arrays, const Stream& stream)
{
    pending_ = 0;
    take_memory(stream);
    const auto put = [&](auto& to, const auto& from) { copy_.upload(to.data(), from.data(), from.bytes(), stream); };
    put(color_sum_, arrays.color_sum);
    put(color_sum_squares_, arrays.color_sum_squares);
    put(block_sum_squares_, arrays.block_sum_squares);
    put(block_begin_, arrays.block_begin);
    put(features_, arrays.features);
    empty_ = false;
}

FilmSums PassQueue::sums()
{
    return {color_sum_.data(), color_sum_squares_.data(), block_sum_squares_.data(), block_begin_.data(),
            features_.data()};
}

PassEnd PassQueue::take(const SceneView& scene, std::int64_t sample, const std::atomic<bool>* cancel,
                        const Stream& stream)
{
    if (is_cancelled(cancel))
        return PassEnd::cancelled;
    if (empty_) {
        take_memory(stream);
        for (DeviceArray<double>* sum : {&color_sum_, &color_sum_squares_, &block_sum_squares_, &block_begin_})
            fill_on_device(sum->data(), 0, sum->bytes(), stream);
        fill_on_device(features_.data(), 0, features_.bytes(), stream);
        empty_ = false;
    }
    if (pending_ == 0) {
        scene_ = scene;
        first_pending_ = sample;
    }
    batch_.pass[pending_++] = pass_numbers(scene.seed, sample);
    return pending_ < batch_size_ ? PassEnd::complete : draw(cancel, stream);
}

void PassQueue::draw_pending(const Stream& stream)
{
    if (pending_ > 0)
        draw(nullptr, stream);
}

/// The host goes on when all launches but the last have ended.
void PassQueue::keep_two_launches(const Stream& stream)
{
    launched_[launches_++ % 2].record(stream);
    launched_[launches_ % 2].wait();
}

PassEnd PassQueue::draw(const std::atomic<bool>* cancel, const Stream& stream)
{
    const int count = std::exchange(pending_, 0);
    const std::uint32_t numbers = batch_.numbers_a_sample() * static_cast<std::uint32_t>(count);
    for (std::uint32_t begin = 0; begin < numbers;) {
        // Batches of several passes take one launch and are not given up: their passes count as drawn.
        if (count == 1 && is_cancelled(cancel))
            return PassEnd::cancelled;
        const std::uint32_t end = begin + std::min(numbers - begin, paths_a_launch_);
        fill_on_device(&counters_.data()->next, 0, sizeof(std::uint32_t), stream);
        draw_paths(scene_, batch_, begin, end, counters_.data(), multiprocessors_, stream);
        keep_two_launches(stream);
        begin = end;
    }
    add_to_film(sums(), batch_, count, first_pending_, stream);
    return PassEnd::complete;
}

void PassQueue::fetch(FilmArrays& arrays, const Stream& stream)
{
    draw_pending(stream);
    const auto get = [&](auto& to, const auto& from) {
        if (empty_)
            std::fill(to.begin(), to.end(), 0.0F);
        else
            copy_.download(to.data(), from.data(), to.bytes(), stream);
    };
    get(arrays.color_sum, color_sum_);
    get(arrays.color_sum_squares, color_sum_squares_);
    get(arrays.block_sum_squares, block_sum_squares_);
    get(arrays.block_begin, block_begin_);
    get(arrays.features, features_);
    stream.wait();
}

PassCounts PassQueue::counts(const Stream& stream)
{
    if (counters_.empty())
        return {};
    draw_pending(stream);
    PathCounters counters;
    copy_to_host(&counters, counters_.data(), sizeof(counters), stream);
    stream.wait();
    PassCounts counts;
    counts.paths = counters.of[PathCounters::paths];
    counts.shadow_rays = counters.of[PathCounters::shadow_rays];
    counts.camera_steps = counters.of[PathCounters::camera_steps];
    counts.shadow_steps = counters.of[PathCounters::shadow_steps];
    counts.advance_steps = counters.of[PathCounters::advance_steps];
    counts.advance_lanes = counters.of[PathCounters::advance_lanes];
    counts.candidate_lanes = counters.of[PathCounters::candidate_lanes];
    return counts;
}

std::uint64_t PassQueue::bytes() const
{
    return 4 * color_sum_.bytes() + features_.bytes() + sample_color_.bytes() + sample_features_.bytes();
}

std::uint64_t PassQueue::bytes_needed(int width, int height, int multiprocessors)
{
    SampleBatch batch;
    batch.width = width;
    batch.height = height;
    const auto samples = static_cast<std::uint64_t>(batch_of(batch.numbers_a_sample(), launch_of(multiprocessors)));
    constexpr std::uint64_t film = 12 * sizeof(double) + feature_count * sizeof(float);
    constexpr std::uint64_t sample = (3 + feature_count) * sizeof(float);
    return batch.pixels() * (film + sample * samples);
}

} // namespace lumisweep::LUMISWEEP_CUDA

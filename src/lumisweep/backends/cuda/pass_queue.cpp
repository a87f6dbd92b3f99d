#include "lumisweep/backends/cuda/pass_queue.h"

#include <algorithm>

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

void PassQueue::clear(int width, int height, const Stream& stream)
{
    pending_ = 0;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (DeviceArray<double>* sum : {&color_sum_, &color_sum_squares_, &block_sum_squares_, &block_begin_}) {
        sum->resize(3 * pixels, "the film");
        fill_on_device(sum->data(), 0, sum->bytes(), stream);
    }
    features_.resize(feature_count * pixels, "the film");
    fill_on_device(features_.data(), 0, features_.bytes(), stream);
    batch_.width = width;
    batch_.height = height;
    batch_size_ = batch_of(batch_.numbers_a_sample(), paths_a_launch_);
    sample_color_.resize(3 * pixels * static_cast<std::size_t>(batch_size_), "samples of a batch of passes");
    sample_features_.resize(feature_count * pixels * static_cast<std::size_t>(batch_size_),
                            "samples of a batch of passes");
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
    color_sum_.upload(arrays.color_sum.span(), "the film", stream);
    color_sum_squares_.upload(arrays.color_sum_squares.span(), "the film", stream);
    block_sum_squares_.upload(arrays.block_sum_squares.span(), "the film", stream);
    block_begin_.upload(arrays.block_begin.span(), "the film", stream);
    features_.upload(arrays.features.span(), "the film", stream);
    stream.wait();
}

FilmSums PassQueue::sums()
{
    return {color_sum_.data(), color_sum_squares_.data(), block_sum_squares_.data(), block_begin_.data(),
            features_.data()};
}

PassEnd PassQueue::take(const SceneView& scene, std::int64_t sample, const std::atomic<bool>* cancel,
                        const Stream& stream)
{
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed))
        return PassEnd::cancelled;
    if (pending_ == 0) {
        scene_ = scene;
        first_pending_ = sample;
    }
    batch_.pass[pending_++] = pass_numbers(scene.seed, sample);
    return pending_ < batch_size_ ? PassEnd::complete : draw(cancel, stream);
}

void PassQueue::wait_for_one(const Stream& stream)
{
    Event& launched = launched_[launches_++ % launches_ahead];
    launched.record(stream);
    launched_[launches_ % launches_ahead].wait();
}

PassEnd PassQueue::draw(const std::atomic<bool>* cancel, const Stream& stream)
{
    const int count = std::exchange(pending_, 0);
    const std::uint32_t numbers = batch_.numbers_a_sample() * static_cast<std::uint32_t>(count);
    for (std::uint32_t begin = 0; begin < numbers;) {
        // Batches of several passes take one launch and are not given up: their passes count as drawn.
        if (count == 1 && cancel != nullptr && cancel->load(std::memory_order_relaxed))
            return PassEnd::cancelled;
        const std::uint32_t end = begin + std::min(numbers - begin, paths_a_launch_);
        fill_on_device(&counters_.data()->next, 0, sizeof(std::uint32_t), stream);
        draw_paths(scene_, batch_, begin, end, counters_.data(), multiprocessors_, stream);
        wait_for_one(stream);
        begin = end;
    }
    add_to_film(sums(), batch_, count, first_pending_, stream);
    return PassEnd::complete;
}

void PassQueue::fetch(FilmArrays& arrays, const Stream& stream)
{
    if (pending_ > 0)
        draw(nullptr, stream);
    color_sum_.download(arrays.color_sum.span(), stream);
    color_sum_squares_.download(arrays.color_sum_squares.span(), stream);
    block_sum_squares_.download(arrays.block_sum_squares.span(), stream);
    block_begin_.download(arrays.block_begin.span(), stream);
    features_.download(arrays.features.span(), stream);
    stream.wait();
}

PassCounts PassQueue::counts(const Stream& stream)
{
    if (counters_.empty())
        return {};
    if (pending_ > 0)
        draw(nullptr, stream);
    PathCounters counters;
    copy_to_host(&counters, counters_.data(), sizeof(counters), stream);
    stream.wait();
    PassCounts counts;
    counts.paths = counters.paths;
    counts.shadow_rays = counters.shadow_rays;
    counts.camera_steps = counters.camera_steps;
    counts.shadow_steps = counters.shadow_steps;
    counts.advance_steps = counters.advance_steps;
    counts.advance_lanes = counters.advance_lanes;
    counts.candidate_lanes = counters.candidate_lanes;
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

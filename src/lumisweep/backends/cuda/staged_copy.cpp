#include "lumisweep/backends/cuda/staged_copy.h"

#include <algorithm>
#include <cstring>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

constexpr std::size_t stage_bytes = std::size_t{8} << 20;
constexpr std::size_t piece_bytes = std::size_t{1} << 20; // that a thread copies at a time

void copy_in_pieces(std::byte* to, const std::byte* from, std::size_t bytes)
{
    parallel_for(std::size_t{0}, (bytes + piece_bytes - 1) / piece_bytes, [&](std::size_t piece) {
        const std::size_t first = piece * piece_bytes;
        std::memcpy(to + first, from + first, std::min(piece_bytes, bytes - first));
    });
}

} // namespace

void StagedCopy::take_memory()
{
    for (PinnedArray<std::byte>& stage : stage_)
        if (stage.size() == 0)
            stage = PinnedArray<std::byte>(stage_bytes);
}

bool StagedCopy::upload(void* to, const void* from, std::size_t bytes, const Stream& stream,
                        const std::atomic<bool>* cancel)
{
    take_memory();
    bool cancelled = false;
    for (std::size_t at = 0, which = 0; at < bytes && !cancelled; at += stage_bytes, which = 1 - which) {
        const std::size_t count = std::min(stage_bytes, bytes - at);
        passed_[which].wait();
        copy_in_pieces(stage_[which].data(), static_cast<const std::byte*>(from) + at, count);
        copy_to_device(static_cast<std::byte*>(to) + at, stage_[which].data(), count, stream);
        passed_[which].record(stream);
        cancelled = is_cancelled(cancel);
    }
    stream.wait();
    return !cancelled;
}

void StagedCopy::download(void* to, const void* from, std::size_t bytes, const Stream& stream)
{
    take_memory();
    const auto begin = [&](std::size_t at, std::size_t which) {
        if (at >= bytes)
            return;
        copy_to_host(stage_[which].data(), static_cast<const std::byte*>(from) + at, std::min(stage_bytes, bytes - at),
                     stream);
        passed_[which].record(stream);
    };
    begin(0, 0);
    for (std::size_t at = 0, which = 0; at < bytes; at += stage_bytes, which = 1 - which) {
        begin(at + stage_bytes, 1 - which);
        passed_[which].wait();
        copy_in_pieces(static_cast<std::byte*>(to) + at, stage_[which].data(), std::min(stage_bytes, bytes - at));
    }
}

} // namespace lumisweep::LUMISWEEP_CUDA

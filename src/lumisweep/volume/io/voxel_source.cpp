#include "lumisweep/volume/io/voxel_source.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "lumisweep/base/error.h"

namespace lumisweep {

FileVoxels::FileVoxels(std::unique_ptr<ByteSource> bytes, std::uint64_t data_offset, const FrameLayout& layout,
                       int frame)
    : bytes_(std::move(bytes)), data_offset_(data_offset), layout_(layout), frame_(static_cast<std::uint64_t>(frame))
{
    rewind();
}

void FileVoxels::rewind()
{
    bytes_->rewind();
    bytes_->skip(data_offset_ + frame_ * layout_.inner_bytes);
    left_in_run_ = layout_.inner_bytes;
    left_in_frame_ = layout_.frame_bytes();
}

void FileVoxels::read(std::span<std::byte> bytes)
{
    LUMISWEEP_EXPECT(bytes.size() <= left_in_frame_);
    while (!bytes.empty()) {
        if (left_in_run_ == 0) {
            bytes_->skip((layout_.frames - 1) * layout_.inner_bytes);
            left_in_run_ = layout_.inner_bytes;
        }
        const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), left_in_run_));
        bytes_->read(bytes.first(n));
        left_in_run_ -= n;
        left_in_frame_ -= n;
        bytes = bytes.subspan(n);
    }
    if (left_in_frame_ == 0 && frame_ + 1 == layout_.frames)
        bytes_->check_end();
}

MemoryVoxels::MemoryVoxels(std::shared_ptr<const void> owner, const std::byte* data, const FrameLayout& layout,
                           int frame)
    : owner_(std::move(owner)), data_(data), layout_(layout), frame_(static_cast<std::uint64_t>(frame))
{
}

void MemoryVoxels::read(std::span<std::byte> bytes)
{
    LUMISWEEP_EXPECT(position_ + bytes.size() <= layout_.frame_bytes());
    while (!bytes.empty()) {
        const std::uint64_t run = position_ / layout_.inner_bytes, within = position_ % layout_.inner_bytes;
        const std::size_t n =
            static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), layout_.inner_bytes - within));
        std::memcpy(bytes.data(), data_ + (run * layout_.frames + frame_) * layout_.inner_bytes + within, n);
        position_ += n;
        bytes = bytes.subspan(n);
    }
}

} // namespace lumisweep

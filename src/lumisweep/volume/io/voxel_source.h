// One frame's voxels as they are stored, front to back: what file formats hand to read_grid().
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumisweep/volume/io/byte_source.h"

namespace lumisweep {

class VoxelSource {
public:
    virtual ~VoxelSource() = default;
    /// Back to the frame's first voxel.
    virtual void rewind() = 0;
    /// The next bytes of the frame; throws Error when the file ends before.
    virtual void read(std::span<std::byte> bytes) = 0;
};

/// Where a frame lies among the others: `outer` runs of `inner_bytes`, each followed by those of the other frames. Time
/// as the last axis is outer = 1; a list axis before x is inner_bytes = one voxel.
struct FrameLayout {
    std::uint64_t inner_bytes = 0;
    std::uint64_t frames = 1;
    std::uint64_t outer = 1;
    std::uint64_t frame_bytes() const { return inner_bytes * outer; }
    std::uint64_t total_bytes() const { return inner_bytes * outer * frames; }
};

/// A frame in a file, `data_offset` bytes into the (decompressed) source.
class FileVoxels : public VoxelSource {
public:
    FileVoxels(std::unique_ptr<ByteSource> bytes, std::uint64_t data_offset, const FrameLayout& layout, int frame);
    void rewind() override;
    void read(std::span<std::byte> bytes) override;

private:
    std::unique_ptr<ByteSource> bytes_;
    std::uint64_t data_offset_;
    FrameLayout layout_;
    std::uint64_t frame_;
    std::uint64_t left_in_run_ = 0;
    std::uint64_t left_in_frame_ = 0;
};

/// A frame of an array in memory that `owner` keeps alive.
class MemoryVoxels : public VoxelSource {
public:
    MemoryVoxels(std::shared_ptr<const void> owner, const std::byte* data, const FrameLayout& layout, int frame);
    void rewind() override { position_ = 0; }
    void read(std::span<std::byte> bytes) override;

private:
    std::shared_ptr<const void> owner_;
    const std::byte* data_;
    FrameLayout layout_;
    std::uint64_t frame_;
    std::uint64_t position_ = 0; // within the frame
};

} // namespace lumisweep

// The file formats: each opens a file as a header and a way to get at one frame's voxels.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "lumisweep/volume/io/load_volume.h"
#include "lumisweep/volume/io/read_grid.h"
#include "lumisweep/volume/io/voxel_source.h"

namespace lumisweep {

struct OpenedVolume {
    VolumeHeader header;
    StoredType type = StoredType::u8;
    ByteOrder order = ByteOrder::native;
    std::uint64_t working_bytes = 0; ///< memory that the voxel source itself takes
    /// Voxels of one frame in [0, header.frames). Keeps what it needs; takes working_bytes when called.
    std::function<std::unique_ptr<VoxelSource>(int frame)> voxels;
};

OpenedVolume open_nrrd(const std::filesystem::path& path);
OpenedVolume open_meta_image(const std::filesystem::path& path);
OpenedVolume open_nifti(const std::filesystem::path& path);
/// `path` is a directory with a series, or one file.
OpenedVolume open_dicom(const std::filesystem::path& path);

} // namespace lumisweep

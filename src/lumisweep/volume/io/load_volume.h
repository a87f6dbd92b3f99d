// Volume files: NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI-1 (.nii, .nii.gz), DICOM (a directory or a file).
//
// The libraries that come with ITK read the headers and decode DICOM: Teem's NrrdIO, niftiio, DCMTK. ImageIO itself is
// passed over because it replaces NaN in NIfTI by zeros, turns scaled integers into floats, refuses sheared grids, and
// reads every frame of a 4-D file where one is wanted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

struct VolumeRequest {
    /// One file, one directory with a DICOM series, or several files: a time series in the given order.
    std::vector<std::filesystem::path> files;
    int frame = 0; ///< of all the files' frames, one after the other
};

/// What a volume file says about itself; no voxel has been read.
struct VolumeHeader {
    std::string format;        ///< "NRRD", "MetaImage", "NIfTI", "DICOM"
    std::string voxel_type;    ///< in the file: "int8", "uint16", "float64", …
    std::string modality;      ///< DICOM's code ("CT", "MR", …); empty when unknown
    Vec3i size{0, 0, 0};       ///< voxels along x, y, z of one frame; 2-D images have size.z = 1
    Vec3d spacing{1, 1, 1};    ///< lengths of the columns of world_from_voxel
    Affine3d world_from_voxel; ///< to LPS millimetres; the sample of voxel i is at p_voxel = i + 0.5
    int frames = 1;
    double slope = 1.0, intercept = 0.0; ///< value = slope · voxel + intercept
    std::uint64_t bytes_needed = 0;      ///< an upper bound for loading one frame, working memory included
    std::vector<std::string> warnings;   ///< one line each
};

struct LoadedVolume {
    ScalarGrid grid;
    std::string modality; ///< "CT", "MR", … or empty when unknown
    std::string format;
    int frames = 1;                    ///< in all files together
    std::vector<std::string> warnings; ///< one line each
    std::size_t non_finite = 0;        ///< NaN or infinite voxels, NaN in the grid
};

/// Reads the header only. Throws Error for anything that load_volume would refuse without reading voxels.
VolumeHeader inspect_volume(const std::filesystem::path& path);

/// Reads one frame. Voxels of type u8, u16, i16 and float keep their type; i8 becomes i16; wider integers and doubles
/// become the smallest of u8, u16, i16 that holds every value exactly, else float (with a warning when digits are
/// lost). Throws Error for files that are missing, damaged, truncated, too large for the memory at hand, or hold no
/// scalars.
LoadedVolume load_volume(const VolumeRequest& request);

} // namespace lumisweep

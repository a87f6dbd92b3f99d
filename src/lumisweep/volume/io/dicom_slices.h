// The slices of a DICOM series as their headers describe them, and the series' order in space.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lumisweep/volume/io/load_volume.h"
#include "lumisweep/volume/io/read_grid.h"

namespace lumisweep {

/// One image plane: a file of a classic series, or one frame of a multi-frame file.
struct DicomSlice {
    std::filesystem::path file;
    std::uint64_t frame = 0; ///< within the file
    Vec3d position{0, 0, 0}; ///< centre of the first pixel, LPS mm
    bool has_position = false;
    int instance = 0;
    double slope = 1.0, intercept = 0.0;
    StoredType type = StoredType::u8;
    std::optional<std::uint16_t> padding; ///< the stored bits of pixels outside of what was scanned
};

/// Slices of one series that share size and orientation.
struct DicomSeries {
    std::string uid, modality;
    std::uint64_t columns = 0, rows = 0;
    Vec3d row_direction{1, 0, 0};                   ///< along which the column index grows
    Vec3d column_direction{0, 1, 0};                ///< along which the row index grows
    double column_spacing = 1.0, row_spacing = 1.0; ///< along row_direction, along column_direction
    double thickness = 0.0;                         ///< the header's distance between slices; 0 when unknown
    std::vector<DicomSlice> slices;
    std::vector<std::string> warnings;
};

/// Each frame of a file as a series of its own; empty for what is no DICOM image. Throws Error for images that no
/// volume can be made of. prepare_dcmtk() comes first.
std::vector<DicomSeries> read_dicom_header(const std::filesystem::path& file);

/// The largest series in a directory, or the one in a file. What is left out is named in the warnings. Throws Error
/// when there is none.
DicomSeries find_dicom_series(const std::filesystem::path& path);

/// Where an output slice lies between input slices `below` and `above` = below + 1 (or equal, at weight 0).
struct SliceBlend {
    std::size_t below = 0, above = 0;
    double weight = 0.0; ///< of `above`
};

/// A series in order: slices sorted, doubles removed, and what each slice of a regular grid is made of.
struct SliceStack {
    std::vector<DicomSlice> slices;
    std::vector<SliceBlend> planes; ///< one per slice of the grid
    Vec3d step{0, 0, 1};            ///< between planes, mm; any direction (gantry tilt)
    Vec3d origin{0, 0, 0};
    bool resampled = false;
};

/// Sorts along the slices' normal. Irregular gaps (more than 1 % off their mean) become regular planes, with a warning.
SliceStack stack_slices(const DicomSeries& series, const std::string& where, std::vector<std::string>& warnings);

} // namespace lumisweep

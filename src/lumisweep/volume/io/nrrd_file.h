// Teem's NrrdIO as C++ owns it.
#pragma once

#include <filesystem>
#include <memory>

#include <NrrdIO.h>

#include "lumisweep/volume/io/load_volume.h"
#include "lumisweep/volume/io/voxel_source.h"

namespace lumisweep {

struct NrrdDelete {
    void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
};
struct NrrdIoDelete {
    void operator()(NrrdIoState* io) const { nrrdIoStateNix(io); }
};
using NrrdPtr = std::unique_ptr<Nrrd, NrrdDelete>;
using NrrdIoPtr = std::unique_ptr<NrrdIoState, NrrdIoDelete>;

enum class NrrdPart { header, all };

/// Loads the header, or header and voxels; throws Error in one line.
void load_nrrd(Nrrd& nrrd, NrrdIoState& io, const std::filesystem::path& path, NrrdPart part);

/// Which axes of the file are x, y, z and frames, and where that puts the grid. Fills size, frames, geometry and
/// warnings of `header` and returns the layout of a frame; throws Error for axes that are no scalar volume.
FrameLayout interpret_nrrd_axes(const Nrrd& nrrd, VolumeHeader& header, const std::string& where);

} // namespace lumisweep

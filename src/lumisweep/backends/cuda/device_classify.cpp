#include "lumisweep/backends/cuda/device_classify.h"

#include "lumisweep/backends/cuda/classify_kernels.h"
#include "lumisweep/visibility/classify_setup.h"
#include "lumisweep/visibility/dither.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceClassify::classify(DeviceExtinction& extinction, const void* voxels_on_device, const ScalarGrid& volume,
                              const RawRange& range, const TransferFunction& tf,
                              const DeviceTransferFunction& on_device, int mip_level, const Stream& stream)
{
    extinction.resize(level_size(volume.size(), mip_level));
    extinction.volume_size = volume.size();
    extinction.world_from_voxel = volume.world_from_voxel();
    extinction.mip_level = mip_level;
    const double scale = extinction_of_step(volume, range, tf);
    extinction.scale = static_cast<float>(scale);
    if (!(extinction.scale > 0.0F))
        return;

    if (dither_.empty())
        dither_.upload({dither_numbers(), dither_count}, "dithering", stream);
    ClassifyWork work;
    work.voxels = voxels_on_device;
    work.type = volume.type();
    work.volume_size = volume.size();
    work.mip_level = mip_level;
    work.size = extinction.size;
    work.dither = dither_.data();
    work.rows = extinction.straight.data();
    work.pitch = row_pitch(extinction.size.x);
    if (volume.type() == VoxelType::f32) {
        work.floats = classification_of_floats(volume, tf, scale);
        work.floats.tf = on_device.view(volume.slope(), volume.intercept());
    } else {
        work.table_first = static_cast<int>(range.low);
        table_.resize(static_cast<std::size_t>(static_cast<int>(range.high) - work.table_first + 1), "classification");
        work.table = table_.data();
        launch_table({table_.data(), work.table_first, static_cast<int>(table_.size()), on_device.points(),
                      volume.slope(), volume.intercept(), scale},
                     stream);
    }
    if (mip_level < 2)
        launch_classify_fine(work, stream);
    else
        launch_classify_coarse(work, stream);
    launch_transpose(
        {extinction.rows_along_x(), extinction.transposed.data(), row_pitch(extinction.size.y), extinction.size},
        stream);
}

} // namespace lumisweep::LUMISWEEP_CUDA

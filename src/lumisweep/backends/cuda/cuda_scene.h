// A session's scene in the device's memory: the graph of docs/architecture.md with every stage on the device.
#pragma once

#include <memory>

#include "lumisweep/backends/cuda/device_classify.h"
#include "lumisweep/backends/cuda/device_environment.h"
#include "lumisweep/backends/cuda/device_joint.h"
#include "lumisweep/backends/cuda/device_majorants.h"
#include "lumisweep/backends/cuda/device_sweep.h"
#include "lumisweep/backends/cuda/device_volume.h"
#include "lumisweep/backends/cuda/pass_queue.h"
#include "lumisweep/render/device_scene.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// All work goes through one stream, in order. Stages are waited for, so that their times are theirs; passes are not.
/// Only voxels of a volume to come are copied beside it.
class CudaScene final : public DeviceScene {
public:
    explicit CudaScene(const DeviceInfo& device) : passes_(device.multiprocessors) {}

    void require_memory(const SessionInput& input) override;
    void set_volume(std::shared_ptr<const ScalarGrid> volume) override;
    void prefetch(std::shared_ptr<const ScalarGrid> volume) override;
    void set_transfer_function(const TransferFunction& transfer_function) override;
    void set_environment(std::shared_ptr<const Environment> environment) override;
    bool sweep(const VisibilitySettings& settings, const std::atomic<bool>* cancel, SessionStats& stats) override;
    void build_joint(JointFactor factor, double epsilon) override;
    const VisibilityGrid& visibility() override;
    void set_visibility(VisibilityGrid grid) override;
    void clear_film(int width, int height) override { passes_.clear(width, height); }
    void restore_film(const Film& film) override { passes_.restore(film.arrays(), stream_); }
    PassEnd render_pass(const SceneView& scene, std::int64_t sample, const std::atomic<bool>* cancel) override;
    PassCounts counts() override { return passes_.counts(stream_); }
    Bytes bytes() const override;
    void fetch(FilmArrays& arrays) override { passes_.fetch(arrays, stream_); }

private:
    /// Of what this input uses, not of what is kept for later.
    std::uint64_t held_bytes() const;

    Stream stream_;
    std::uint64_t needed_ = 0; ///< by the input that was asked for last
    DeviceVolume volume_;
    DeviceBounds bounds_;
    TransferFunction transfer_function_;
    DeviceTransferFunction tables_; ///< of it
    DeviceMajorants majorants_;
    std::shared_ptr<const Environment> light_;
    DeviceEnvironment environment_;
    DeviceClassify classify_;
    DeviceExtinction extinction_;
    DeviceSweep sweep_;
    DeviceVisibility visibility_;
    Vec3i swept_size_{0, 0, 0}; ///< of it: the volume's voxels …
    int voxels_per_cell_ = 0;   ///< … and a cell's
    VisibilityGrid looked_at_;  ///< copy of visibility_, if it is of its shape and up to date
    bool looked_at_is_old_ = true;
    DeviceJoint joint_;
    PassQueue passes_;
};

} // namespace lumisweep::LUMISWEEP_CUDA

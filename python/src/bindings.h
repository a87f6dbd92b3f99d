// What the parts of the Python module share: handles of the library's objects, and running without the interpreter.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>
#include <tbb/task_arena.h>

#include "lumisweep/lumisweep.h"

namespace lumisweep::python {

namespace py = pybind11;

// Each adds its classes and functions; in this order, as each may have default arguments of the classes before.
void bind_volume(py::module_& module);
void bind_transfer_function(py::module_& module);
void bind_environment(py::module_& module);
void bind_settings(py::module_& module);
void bind_image(py::module_& module);
void bind_visibility(py::module_& module);
void bind_sampler(py::module_& module);
void bind_session(py::module_& module);

/// A volume with what its file or array said beside the voxels.
struct VolumeHandle {
    std::shared_ptr<const ScalarGrid> grid;
    std::string modality;
    int frames = 1;
    bool shared = false; ///< the voxels are the caller's array
    std::vector<std::string> warnings;
};

struct EnvironmentHandle {
    std::shared_ptr<const Environment> light;
    std::vector<std::string> warnings;
};

struct ImageHandle {
    Image image;
    Background background = Background::opaque; ///< as it was rendered
};

struct VisibilityHandle {
    std::shared_ptr<const VisibilityGrid> grid;
    py::dict stats;
};

/// Whether the interpreter is about to end, in another thread: those that ask for its lock from then on are killed.
bool interpreter_is_ending();
/// Has that known; once.
void watch_interpreter();

/// What the machine has.
int all_threads();
/// The threads that a call may use: `threads` as in Python, 0 for all.
std::unique_ptr<tbb::task_arena> make_arena(int threads);

/// Calls work(cancel) in the arena, on a thread of its own and without the interpreter, while this thread looks for
/// signals: at Ctrl-C it sets `cancel`, waits for the work to return, and throws KeyboardInterrupt.
void run_interruptible(tbb::task_arena& arena, const std::function<void(const std::atomic<bool>& cancel)>& work);

/// The volume classified as sweeps see it, with rays 2^mip_level voxels apart.
ExtinctionGrid classify_level(const ScalarGrid& volume, const TransferFunction& transfer_function, int mip_level,
                              ExtinctionLayouts layouts, const std::atomic<bool>& cancel);
/// A sweep of all directions; the handle has its statistics.
std::shared_ptr<VisibilityHandle> sweep(const ScalarGrid& volume, const TransferFunction& transfer_function,
                                        const VisibilitySettings& settings, tbb::task_arena& arena);
VisibilityGrid copy_of(const VisibilityGrid& grid, Vec3i volume_size, int cell);

Strategy strategy_of(const std::string& name);

/// The preset that suits the data, or the named one; `note` receives what was chosen.
TransferFunction preset_for(const VolumeHandle& volume, const std::string& name, double extinction_scale,
                            std::string* note = nullptr);
Camera framed_camera(const VolumeHandle& volume, const TransferFunction& transfer_function, const ImageSettings& image,
                     double vertical_fov_deg);

} // namespace lumisweep::python

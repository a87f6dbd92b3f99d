#include "lumisweep/backends/cpu/cpu_backend.h"

#include <algorithm>

#include <fmt/ranges.h>

#include <tbb/enumerable_thread_specific.h>

#include "lumisweep/backends/cpu/tile.h"
#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/render/backend.h"

namespace lumisweep {

namespace {

struct InstructionSet {
    const char* name;
    RenderTile render_tile;
    bool (*runs_here)();
};

constexpr InstructionSet instruction_sets[] = {
#if defined(__x86_64__)
    {"avx512", render_tile_avx512,
     [] {
         return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
     }},
    {"avx2", render_tile_avx2,
     [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"); }},
#endif
    {"baseline", render_tile_baseline, [] { return true; }},
};

class CpuBackend final : public HostBackend {
public:
    explicit CpuBackend(const InstructionSet& set) : set_(set) {}

    std::string device() const override { return "cpu"; }
    std::string isa() const override { return set_.name; }

    PassEnd render_pass(const SceneView& scene, const SampleView& samples, std::int64_t sample,
                        const std::atomic<bool>* cancel, PassCounts& counts) override
    {
        const PassNumbers pass = pass_numbers(scene.seed, sample);
        const int width = scene.camera.width, height = scene.camera.height;
        // Enough tiles for the threads to share, each enough pixels to keep a stream full.
        const int side = static_cast<std::int64_t>(width) * height >= 256 * 256 ? 64 : 32;
        const int columns = (width + side - 1) / side, rows = (height + side - 1) / side;
        tbb::enumerable_thread_specific<PassCounts> thread_counts;
        std::atomic<bool> stopped = false;
        parallel_for(0, columns * rows, [&](int t) {
            if (stopped.load(std::memory_order_relaxed) || is_cancelled(cancel)) {
                stopped.store(true, std::memory_order_relaxed);
                return;
            }
            const int x0 = t % columns * side, y0 = t / columns * side;
            set_.render_tile(scene, samples, pass, {x0, y0, std::min(x0 + side, width), std::min(y0 + side, height)},
                             thread_counts.local());
        });
        for (const PassCounts& c : thread_counts)
            counts += c;
        return stopped ? PassEnd::cancelled : PassEnd::complete;
    }

private:
    InstructionSet set_;
};

} // namespace

std::vector<std::string> available_isas()
{
    std::vector<std::string> names;
    for (const InstructionSet& set : instruction_sets) {
        if (set.runs_here())
            names.emplace_back(set.name);
    }
    return names;
}

std::shared_ptr<Backend> make_cpu_backend(const std::string& isa)
{
    for (const InstructionSet& set : instruction_sets) {
        if (set.runs_here() && (isa == "auto" || isa == set.name))
            return std::make_shared<CpuBackend>(set);
    }
    fail("instruction set '{}' is not one that this machine runs (use auto or one of {})", isa,
         fmt::join(available_isas(), ", "));
}

} // namespace lumisweep

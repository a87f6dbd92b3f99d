// The CPU backend: a stream of paths per tile, tiles over threads, the instruction set chosen at start-up.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace lumisweep {

class Backend; // render/backend.h

/// Instruction sets that this build has and this machine runs, best first: "avx512", "avx2", "baseline".
std::vector<std::string> available_isas();

/// `isa` is one of available_isas() or "auto" for the best. Throws Error for any other.
/// Threads are those of the tbb::task_arena that render_pass is called in.
std::shared_ptr<Backend> make_cpu_backend(const std::string& isa = "auto");

} // namespace lumisweep

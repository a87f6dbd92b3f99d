#include <algorithm>
#include <chrono>
#include <exception>
#include <future>
#include <thread>

#include <tbb/info.h>

#include "bindings.h"

namespace lumisweep::python {

namespace {

std::thread::id ending_thread; // written before `ending` is set
std::atomic<bool> ending = false;

} // namespace

bool interpreter_is_ending()
{
    return Py_IsInitialized() == 0 || (ending && std::this_thread::get_id() != ending_thread);
}

void watch_interpreter()
{
    py::module_::import("atexit").attr("register")(py::cpp_function([] {
        ending_thread = std::this_thread::get_id();
        ending = true;
    }));
}

int all_threads() { return tbb::info::default_concurrency(); }

std::unique_ptr<tbb::task_arena> make_arena(int threads)
{
    require(threads >= 0 && threads <= 4096, "threads: {} is not 1 to 4096, nor 0 for all", threads);
    // oneTBB complains on stderr when more are asked for than the machine has.
    return std::make_unique<tbb::task_arena>(threads > 0 ? std::min(threads, all_threads()) : all_threads());
}

void run_interruptible(tbb::task_arena& arena, const std::function<void(const std::atomic<bool>& cancel)>& work)
{
    using namespace std::chrono_literals;
    std::atomic<bool> cancel = false;
    std::promise<void> promise;
    std::future<void> result = promise.get_future();
    bool interrupted = false;
    {
        const py::gil_scoped_release release;
        std::thread worker([&] {
            try {
                arena.execute([&] { work(cancel); });
                promise.set_value();
            } catch (...) {
                promise.set_exception(std::current_exception());
            }
        });
        // Only the main thread of Python gets signals; elsewhere the check does nothing.
        while (!interrupted && result.wait_for(20ms) != std::future_status::ready) {
            if (interpreter_is_ending())
                break;
            const py::gil_scoped_acquire acquire;
            interrupted = PyErr_CheckSignals() != 0;
        }
        cancel = interrupted || interpreter_is_ending();
        worker.join();
        // A daemon thread of Python's that is left behind: it must not come back, and the process takes it along.
        while (interpreter_is_ending())
            std::this_thread::sleep_for(1h);
    }
    if (interrupted)
        throw py::error_already_set();
    result.get();
}

} // namespace lumisweep::python

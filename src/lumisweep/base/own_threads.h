// A parallel loop on std::thread, for builds whose sanitizer cannot look into oneTBB (base/parallel.h).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include <tbb/task_arena.h>

namespace lumisweep {

/// Calls run(first, last) on pieces of [begin, end) of at least `grain`, on as many threads as the current arena has.
template <class Index, class Run>
void for_chunks_on_own_threads(Index begin, Index end, std::size_t grain, const Run& run)
{
    const auto count = static_cast<std::size_t>(end - begin);
    const auto threads = static_cast<std::size_t>(std::max(tbb::this_task_arena::max_concurrency(), 1));
    const std::size_t chunk = std::max(grain, count / (4 * threads) + 1);
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto work = [&] {
        for (std::size_t first = next.fetch_add(chunk); first < count; first = next.fetch_add(chunk)) {
            try {
                run(begin + static_cast<Index>(first), begin + static_cast<Index>(std::min(first + chunk, count)));
            } catch (...) {
                const std::lock_guard lock(failure_mutex);
                failure = std::current_exception();
            }
        }
    };
    std::vector<std::thread> pool;
    for (std::size_t t = 1; t < std::min(threads, count); ++t)
        pool.emplace_back(work);
    work();
    for (std::thread& thread : pool)
        thread.join();
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace lumisweep

// Parallel loops: a thin layer over oneTBB, so that the thread count is that of the calling arena.
#pragma once

#include <cstddef>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

// Debian's oneTBB is not built for ThreadSanitizer, which cannot see how its tasks are ordered and takes every loop for
// a race. Builds for that sanitizer run the same loops on threads of their own.
#if defined(__SANITIZE_THREAD__)
#define LUMISWEEP_OWN_THREADS 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define LUMISWEEP_OWN_THREADS 1
#endif
#endif

#if defined(LUMISWEEP_OWN_THREADS)
#include "lumisweep/base/own_threads.h"
#endif

namespace lumisweep {

/// Calls body(i) for every i in [begin, end), in any order and on any thread of the current tbb::task_arena, at least
/// `grain` neighbours on one thread. Results must not depend on the order. Exceptions pass to the caller.
template <class Index, class Body>
void parallel_for(Index begin, Index end, Body&& body, std::size_t grain = 1)
{
    if (begin >= end)
        return;
    const auto run = [&](Index first, Index last) {
        for (Index i = first; i != last; ++i)
            body(i);
    };
#if defined(LUMISWEEP_OWN_THREADS)
    for_chunks_on_own_threads(begin, end, grain, run);
#else
    tbb::parallel_for(tbb::blocked_range<Index>(begin, end, grain),
                      [&](const tbb::blocked_range<Index>& range) { run(range.begin(), range.end()); });
#endif
}

} // namespace lumisweep

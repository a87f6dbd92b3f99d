// Parallel loops: a thin layer over oneTBB, so that the thread count is that of the calling arena.
#pragma once

#include <cstddef>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace lumisweep {

/// Calls body(i) for every i in [begin, end), in any order and on any thread of the current tbb::task_arena.
/// Results must not depend on the order. Exceptions pass to the caller.
template <class Index, class Body>
void parallel_for(Index begin, Index end, Body&& body, std::size_t grain = 1)
{
    if (begin >= end)
        return;
    tbb::parallel_for(tbb::blocked_range<Index>(begin, end, grain), [&](const tbb::blocked_range<Index>& range) {
        for (Index i = range.begin(); i != range.end(); ++i)
            body(i);
    });
}

} // namespace lumisweep

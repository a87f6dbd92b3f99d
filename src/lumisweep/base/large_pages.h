// Memory in large pages: a volume touches one page where it would touch 512, which saves faults and misses of the TLB.
#pragma once

#include <cstddef>

namespace lumisweep {

inline constexpr std::size_t large_page = std::size_t{2} << 20;
/// Below this a page more or less would weigh too much.
inline constexpr std::size_t large_pages_from = 2 * large_page;

/// At least `bytes` of zeros, aligned to a large page, for which the system is asked to take such pages. Memory is
/// taken when it is first touched. Throws std::bad_alloc.
void* map_large_pages(std::size_t bytes);
/// With the same `bytes`.
void unmap_large_pages(void* address, std::size_t bytes);

} // namespace lumisweep

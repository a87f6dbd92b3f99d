#include "lumisweep/base/large_pages.h"

#include <cstdint>
#include <new>

#include <sys/mman.h>
#include <unistd.h>

namespace lumisweep {
namespace {

/// In ordinary pages, so that a small rest at the end does not take a large one.
std::size_t whole_pages(std::size_t bytes)
{
    const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    return (bytes + page - 1) / page * page;
}

} // namespace

void* map_large_pages(std::size_t bytes)
{
    // A large page more, of which the ends that are not aligned are given back.
    const std::size_t kept = whole_pages(bytes), asked = kept + large_page;
    void* mapped = mmap(nullptr, asked, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED)
        throw std::bad_alloc();
    std::byte* const begin = static_cast<std::byte*>(mapped);
    const std::size_t head = (large_page - reinterpret_cast<std::uintptr_t>(begin) % large_page) % large_page;
    if (head > 0)
        munmap(begin, head);
    if (large_page > head)
        munmap(begin + head + kept, large_page - head);
#if defined(MADV_HUGEPAGE)
    madvise(begin + head, kept, MADV_HUGEPAGE); // a wish: nothing is lost where it is not granted
#endif
    return begin + head;
}

void unmap_large_pages(void* address, std::size_t bytes) { munmap(address, whole_pages(bytes)); }

} // namespace lumisweep

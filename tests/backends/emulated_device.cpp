// backends/cuda/device.h in the host's memory. All is done when a call returns, which is one of the orders that streams
// allow.
#include "backends/emulated_device.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <new>
#include <unordered_map>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"

namespace lumisweep {

namespace {

struct Memory {
    std::mutex mutex;
    std::uint64_t size = std::uint64_t{1} << 40, taken = 0;
    std::unordered_map<void*, std::uint64_t> blocks;
    int until_failure = -1;
};

Memory& memory_of_device()
{
    static Memory memory;
    return memory;
}

std::atomic<std::uint64_t> uploaded{0};

} // namespace

namespace test {

void set_emulated_memory(std::uint64_t bytes)
{
    const std::lock_guard lock(memory_of_device().mutex);
    memory_of_device().size = bytes;
}

void fail_allocation_after(int more)
{
    const std::lock_guard lock(memory_of_device().mutex);
    memory_of_device().until_failure = more;
}

std::uint64_t emulated_memory_taken()
{
    const std::lock_guard lock(memory_of_device().mutex);
    return memory_of_device().taken;
}

std::uint64_t bytes_uploaded() { return uploaded; }

} // namespace test

namespace LUMISWEEP_CUDA {

DeviceInfo open_device() { return {"emulated device", 90, 2, memory_of_device().size}; }

std::uint64_t free_device_memory()
{
    const std::lock_guard lock(memory_of_device().mutex);
    return memory_of_device().size - std::min(memory_of_device().size, memory_of_device().taken);
}

Stream::Stream() = default;
Stream::~Stream() = default;
void Stream::wait() const {}

Event::Event() : handle_(new std::chrono::steady_clock::time_point()) {}
Event::~Event() { delete static_cast<std::chrono::steady_clock::time_point*>(handle_); }
void Event::record(const Stream&)
{
    *static_cast<std::chrono::steady_clock::time_point*>(handle_) = std::chrono::steady_clock::now();
}
void Event::wait() const {}
double Event::seconds(const Event& begin, const Event& end)
{
    return std::chrono::duration<double>(*static_cast<const std::chrono::steady_clock::time_point*>(end.handle_) -
                                         *static_cast<const std::chrono::steady_clock::time_point*>(begin.handle_))
        .count();
}

void* allocate_on_device(std::uint64_t bytes, const char* what)
{
    Memory& memory = memory_of_device();
    const std::uint64_t free = free_device_memory();
    {
        const std::lock_guard lock(memory.mutex);
        require(memory.until_failure < 0 || memory.until_failure-- != 0,
                "device cuda: no memory, as the test wants it");
    }
    require(bytes <= free, "device cuda: {} needs {} of the GPU's memory and {} are free", what, format_bytes(bytes),
            format_bytes(free));
    // Aligned as cudaMalloc aligns, and not zeros.
    void* data = ::operator new (bytes, std::align_val_t{256});
    std::memset(data, 0x5a, bytes);
    const std::lock_guard lock(memory.mutex);
    memory.blocks[data] = bytes;
    memory.taken += bytes;
    return data;
}

void release_on_device(void* data) noexcept
{
    if (data == nullptr)
        return;
    Memory& memory = memory_of_device();
    const std::lock_guard lock(memory.mutex);
    memory.taken -= memory.blocks[data];
    memory.blocks.erase(data);
    ::operator delete (data, std::align_val_t{256});
}

void* allocate_pinned(std::uint64_t bytes) { return ::operator new (bytes, std::align_val_t{64}); }
void release_pinned(void* data) noexcept { ::operator delete (data, std::align_val_t{64}); }

void copy_to_device(void* to, const void* from, std::size_t bytes, const Stream&)
{
    uploaded += bytes;
    if (bytes > 0)
        std::memcpy(to, from, bytes);
}
void copy_to_host(void* to, const void* from, std::size_t bytes, const Stream&)
{
    if (bytes > 0)
        std::memcpy(to, from, bytes);
}
void copy_on_device(void* to, const void* from, std::size_t bytes, const Stream&)
{
    if (bytes > 0)
        std::memcpy(to, from, bytes);
}
void fill_on_device(void* to, std::uint8_t byte, std::size_t bytes, const Stream&)
{
    if (bytes > 0)
        std::memset(to, byte, bytes);
}

} // namespace LUMISWEEP_CUDA

} // namespace lumisweep

// The device as the host sees it: memory, copies, streams, events.
//
// Two implementations: device_cuda.cpp over the CUDA runtime, and one in the host's own memory with which the tests run
// every kernel and all that surrounds it on machines without a GPU (tests/backends/emulated_device.cpp). The second
// lives in a namespace of its own, LUMISWEEP_CUDA, so that one program may hold both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#ifndef LUMISWEEP_CUDA
#define LUMISWEEP_CUDA cuda
#endif

namespace lumisweep::LUMISWEEP_CUDA {

struct DeviceInfo {
    std::string name;
    int compute_capability = 0; ///< 10 · major + minor: 90 for sm_90
    int multiprocessors = 0;
    std::uint64_t memory = 0; ///< bytes
};

/// The device that this process uses: the first that the driver shows (CUDA_VISIBLE_DEVICES chooses). Throws Error, one
/// line, when there is no driver, when it is too old for this program, or when there is no device.
DeviceInfo open_device();

/// Bytes of the device's memory that nobody has taken.
std::uint64_t free_device_memory();

/// An ordered queue of the device's work.
class Stream {
public:
    Stream();
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    /// Waits until all that was put in is done. Throws Error for what went wrong on the device.
    void wait() const;
    void* handle() const { return handle_; } ///< cudaStream_t

private:
    void* handle_ = nullptr;
};

/// A mark in a stream.
class Event {
public:
    Event();
    ~Event();
    Event(const Event&) = delete;
    Event& operator=(const Event&) = delete;

    void record(const Stream& stream);
    /// Waits until the stream has reached the mark; at once when there is none.
    void wait() const;
    /// Between two marks that have been reached.
    static double seconds(const Event& begin, const Event& end);

private:
    void* handle_ = nullptr;
};

/// Throws Error naming `what` and the bytes needed and free when the device has not got them.
void* allocate_on_device(std::uint64_t bytes, const char* what);
void release_on_device(void* memory) noexcept;
/// Page-locked memory of the host, which copies at the bus's full speed and beside other work.
void* allocate_pinned(std::uint64_t bytes);
void release_pinned(void* memory) noexcept;

/// Copies in the order of the stream. From pageable memory of the host a copy may take part of its time at once; memory
/// of the host must stand until the stream has come by.
void copy_to_device(void* to, const void* from, std::size_t bytes, const Stream& stream);
void copy_to_host(void* to, const void* from, std::size_t bytes, const Stream& stream);
void copy_on_device(void* to, const void* from, std::size_t bytes, const Stream& stream);
void fill_on_device(void* to, std::uint8_t byte, std::size_t bytes, const Stream& stream);

/// An array in the device's memory, followed by at least 64 bytes that kernels may read. Uninitialised.
template <class T>
class DeviceArray {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    static constexpr std::size_t readable_behind = 64;

    DeviceArray() = default;
    DeviceArray(std::size_t size, const char* what)
        : data_(static_cast<T*>(allocate_on_device(size * sizeof(T) + readable_behind, what))), size_(size)
    {
    }
    ~DeviceArray() { release_on_device(data_); }
    DeviceArray(DeviceArray&& other) noexcept
        : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0))
    {
    }
    DeviceArray& operator=(DeviceArray&& other) noexcept
    {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }

    T* data() { return data_; }
    const T* data() const { return data_; }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return size_ * sizeof(T); }
    bool empty() const { return size_ == 0; }

    /// Of that size: the memory there is, if it is so large, else new memory, once the old is released. What it held is
    /// lost.
    void resize(std::size_t size, const char* what)
    {
        if (size == size_)
            return;
        *this = DeviceArray();
        *this = DeviceArray(size, what);
    }
    /// Takes the size of `from` and its contents.
    void upload(std::span<const T> from, const char* what, const Stream& stream)
    {
        resize(from.size(), what);
        copy_to_device(data_, from.data(), from.size_bytes(), stream);
    }
    void download(std::span<T> to, const Stream& stream) const
    {
        copy_to_host(to.data(), data_, to.size_bytes(), stream);
    }

private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

/// Page-locked memory of the host. Uninitialised.
template <class T>
class PinnedArray {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    PinnedArray() = default;
    explicit PinnedArray(std::size_t size) : data_(static_cast<T*>(allocate_pinned(size * sizeof(T)))), size_(size) {}
    ~PinnedArray() { release_pinned(data_); }
    PinnedArray(PinnedArray&& other) noexcept
        : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0))
    {
    }
    PinnedArray& operator=(PinnedArray&& other) noexcept
    {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }

    T* data() { return data_; }
    std::size_t size() const { return size_; }

private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

} // namespace lumisweep::LUMISWEEP_CUDA

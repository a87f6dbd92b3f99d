// Aligned, padded arrays for data that SIMD code reads.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

#include "lumisweep/base/large_pages.h"

namespace lumisweep {

/// Whether an array is filled with zeros. What is written as a whole need not be.
enum class Contents { zeros, uninitialised };

/// A fixed-size array of trivially copyable T, aligned to 64 bytes and followed by at least 64 readable bytes of zeros,
/// so that a gather or a full vector load at the last element stays inside the allocation. Arrays of several megabytes
/// come from the system's large pages where it has them (base/large_pages.h).
template <class T>
class AlignedArray {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    static constexpr std::size_t alignment = 64;

    AlignedArray() = default;
    explicit AlignedArray(std::size_t size, Contents contents = Contents::zeros) : size_(size)
    {
        if (size > (static_cast<std::size_t>(-1) - 4 * large_page) / sizeof(T))
            throw std::bad_alloc();
        const std::size_t needed = size * sizeof(T) + alignment;
        if (needed >= large_pages_from) {
            // Zeros already, and not touched before they are used.
            data_ = {static_cast<T*>(map_large_pages(needed)), Free{needed}};
            return;
        }
        const std::size_t bytes = (needed + alignment - 1) / alignment * alignment;
        data_.reset(static_cast<T*>(std::aligned_alloc(alignment, bytes)));
        if (!data_)
            throw std::bad_alloc();
        const std::size_t kept = contents == Contents::zeros ? 0 : size * sizeof(T);
        std::memset(reinterpret_cast<std::byte*>(data_.get()) + kept, 0, bytes - kept);
    }

    T* data() { return data_.get(); }
    const T* data() const { return data_.get(); }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return size_ * sizeof(T); }
    bool empty() const { return size_ == 0; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }
    T* begin() { return data(); }
    T* end() { return data() + size_; }
    const T* begin() const { return data(); }
    const T* end() const { return data() + size_; }
    std::span<T> span() { return {data(), size_}; }
    std::span<const T> span() const { return {data(), size_}; }

private:
    struct Free {
        std::size_t mapped = 0; ///< bytes; 0: from aligned_alloc
        void operator()(T* p) const
        {
            if (mapped > 0)
                unmap_large_pages(p, mapped);
            else
                std::free(p);
        }
    };
    std::unique_ptr<T[], Free> data_;
    std::size_t size_ = 0;
};

} // namespace lumisweep

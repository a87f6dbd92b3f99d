// Transposing bytes in blocks that stay in registers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/base/host_device.h"

namespace lumisweep {

using Bytes16 = std::uint8_t __attribute__((vector_size(16)));

LUMISWEEP_HD Bytes16 zip_low(Bytes16 a, Bytes16 b)
{
    return __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
}
LUMISWEEP_HD Bytes16 zip_high(Bytes16 a, Bytes16 b)
{
    return __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
}

/// 16 × 16: to[x · to_stride + y] = from[y · from_stride + x]. Zipping row r with row r + 8 rotates the bits of
/// (row, column) by one; after four times they have changed places.
LUMISWEEP_HD void transpose_16(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to,
                               std::size_t to_stride)
{
    Bytes16 a[16], b[16];
    for (std::size_t r = 0; r < 16; ++r)
        __builtin_memcpy(&a[r], from + r * from_stride, sizeof(Bytes16)); // rows may lie anywhere
    for (int twice = 0; twice < 2; ++twice) {
        for (std::size_t r = 0; r < 8; ++r) {
            b[2 * r] = zip_low(a[r], a[r + 8]);
            b[2 * r + 1] = zip_high(a[r], a[r + 8]);
        }
        for (std::size_t r = 0; r < 8; ++r) {
            a[2 * r] = zip_low(b[r], b[r + 8]);
            a[2 * r + 1] = zip_high(b[r], b[r + 8]);
        }
    }
    for (std::size_t r = 0; r < 16; ++r)
        __builtin_memcpy(to + r * to_stride, &a[r], sizeof(Bytes16));
}

/// Any width × height.
LUMISWEEP_HD void transpose(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to, std::size_t to_stride,
                            std::size_t width, std::size_t height)
{
    const std::size_t whole_width = width / 16 * 16, whole_height = height / 16 * 16;
    for (std::size_t x = 0; x < whole_width; x += 16)
        for (std::size_t y = 0; y < whole_height; y += 16)
            transpose_16(from + y * from_stride + x, from_stride, to + x * to_stride + y, to_stride);
    for (std::size_t x = 0; x < width; ++x)
        for (std::size_t y = x < whole_width ? whole_height : 0; y < height; ++y)
            to[x * to_stride + y] = from[y * from_stride + x];
}

} // namespace lumisweep

// Images cut into blocks, whose means over batches of passes tests compare.
#pragma once

namespace lumisweep::test {

/// Pixels along the sides of the image and of a block.
inline constexpr int image_side = 32, block_side = 16;
inline constexpr int image_blocks = (image_side / block_side) * (image_side / block_side);
inline constexpr int pixels_of_block = block_side * block_side;
/// Enough that the normal distribution will do at the p-values that matter.
inline constexpr int batches = 24;

constexpr int block_of_pixel(int x, int y) { return y / block_side * (image_side / block_side) + x / block_side; }

} // namespace lumisweep::test

#include "lumisweep/image/png.h"

#include <fstream>
#include <vector>

#include <png.h>

#include "lumisweep/base/error.h"
#include "lumisweep/image/atomic_file.h"

namespace lumisweep {

void write_png(const std::filesystem::path& path, const DisplayImage& image)
{
    const std::string name = path.string();
    require(image.width > 0 && image.height > 0 && (image.channels == 3 || image.channels == 4),
            "{}: an image of {} x {} pixels with {} channels cannot be written (RGB or RGBA)", name, image.width,
            image.height, image.channels);
    const std::size_t values = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                               static_cast<std::size_t>(image.channels);
    require(image.pixels.size() == values, "{}: {} values where {} x {} x {} are needed", name, image.pixels.size(),
            image.width, image.height, image.channels);

    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = image.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    // libpng's simplified interface reports errors by value; no longjmp passes through our frames.
    std::vector<char> encoded;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    encoded.resize(size);
    const int is_encoded = png_image_write_to_memory(&png, encoded.data(), &size, 0, image.pixels.data(), 0, nullptr);
    require(is_encoded != 0, "{}: cannot be encoded: {} (make it smaller)", name, png.message);
    write_atomically(path,
                     [&](std::ofstream& stream) { stream.write(encoded.data(), static_cast<std::streamsize>(size)); });
}

} // namespace lumisweep

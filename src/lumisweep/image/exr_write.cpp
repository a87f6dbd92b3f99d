#include <cmath>
#include <set>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "lumisweep/base/error.h"
#include "lumisweep/image/atomic_file.h"
#include "lumisweep/image/exr.h"
#include "lumisweep/image/exr_detail.h"

namespace lumisweep {
namespace {

void check(const Image& image, const std::string& name)
{
    require(image.width >= 1 && image.height >= 1 && image.width <= exr_detail::max_size &&
                image.height <= exr_detail::max_size,
            "{}: an image of {} x {} pixels cannot be written (1 to {} each way)", name, image.width, image.height,
            exr_detail::max_size);
    require(!image.channels.empty(), "{}: an image without channels cannot be written", name);
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    std::set<std::string> names;
    for (const Channel& channel : image.channels) {
        require(!channel.name.empty() && channel.name.size() < 256 && names.insert(channel.name).second,
                "{}: channel name '{}' is empty, longer than 255 or taken twice", name, channel.name);
        require(channel.pixels.size() == pixels, "{}: channel {} has {} pixels where {} x {} are {}", name,
                channel.name, channel.pixels.size(), image.width, image.height, pixels);
    }
}

Imf::Header header_of(const Image& image, const std::string& name)
{
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const Channel& channel : image.channels)
        header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
    const auto insert = [&](const std::string& key, const Imf::Attribute& attribute) {
        require(!key.empty() && key.size() < 256 && !exr_detail::is_structural(key) && header.find(key) == header.end(),
                "{}: '{}' cannot name an attribute (it is empty, too long, reserved or taken)", name, key);
        header.insert(key, attribute);
    };
    for (const auto& [key, value] : image.text)
        insert(key, Imf::StringAttribute(value));
    for (const auto& [key, value] : image.numbers)
        insert(key, Imf::DoubleAttribute(value));
    for (const auto& [key, value] : image.matrices) {
        require(value.size() == 16, "{}: matrix '{}' has {} numbers (16 are needed)", name, key, value.size());
        Imath::M44f matrix;
        for (std::size_t i = 0; i < 16; ++i)
            matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = static_cast<float>(value[i]);
        insert(key, Imf::M44fAttribute(matrix));
    }
    return header;
}

} // namespace

void write_exr(const std::filesystem::path& path, const Image& image)
{
    const std::string name = path.string();
    check(image, name);
    try {
        const Imf::Header header = header_of(image, name);
        write_atomically(path, [&](std::ofstream& stream) {
            Imf::StdOFStream out(stream, path.c_str());
            Imf::OutputFile file(out, header, exr_detail::threads());
            Imf::FrameBuffer buffer;
            for (const Channel& channel : image.channels)
                buffer.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, channel.pixels.data(), header.dataWindow()));
            file.setFrameBuffer(buffer);
            file.writePixels(image.height);
        });
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        fail("{}: writing failed: {} (is the disk full?)", name, exr_detail::one_line(e.what()));
    }
}

} // namespace lumisweep

#include "lumisweep/image/exr.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "lumisweep/base/error.h"
#include "lumisweep/image/exr_detail.h"
#include "lumisweep/image/exr_header.h"

namespace lumisweep {
namespace {

class MemoryStream : public Imf::IStream {
public:
    MemoryStream(std::span<const std::byte> bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}

    bool read(char* out, int count) override
    {
        if (count < 0 || position_ > bytes_.size() || bytes_.size() - position_ < static_cast<std::size_t>(count))
            throw Iex::InputExc("Unexpected end of file");
        std::memcpy(out, bytes_.data() + position_, static_cast<std::size_t>(count));
        position_ += static_cast<std::size_t>(count);
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override { position_ = position; }

private:
    std::span<const std::byte> bytes_;
    std::uint64_t position_ = 0;
};

class Reader {
public:
    Reader(Imf::IStream& stream, std::string name) : stream_(stream), name_(std::move(name)) {}

    Image read()
    {
        Imf::MultiPartInputFile file(stream_, exr_detail::threads());
        const Imf::Header& header = file.header(0);
        data_ = header.dataWindow();
        display_ = header.displayWindow();
        require(data_.intersects(display_), "{}: its data window lies outside of its display window (save it again)",
                name_);
        image_.width = display_.max.x - display_.min.x + 1;
        image_.height = display_.max.y - display_.min.y + 1;
        read_attributes(header);
        if (has_chroma(header)) {
            require(file.parts() == 1, "{}: luminance-chroma in several parts (save the first one by itself)", name_);
            read_luminance_chroma();
        } else {
            read_channels(file, header.channels());
        }
        return std::move(image_);
    }

private:
    static bool has_chroma(const Imf::Header& header)
    {
        const Imf::ChannelList& c = header.channels();
        return c.findChannel("Y") && c.findChannel("RY") && c.findChannel("BY") && !c.findChannel("R");
    }

    void read_attributes(const Imf::Header& header)
    {
        const auto keep_matrix = [&](const char* key, const auto& m) {
            std::vector<double>& numbers = image_.matrices[key];
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j)
                    numbers.push_back(m[i][j]);
        };
        for (auto it = header.begin(); it != header.end(); ++it) {
            const Imf::Attribute& attribute = it.attribute();
            if (exr_detail::is_structural(it.name()))
                continue;
            if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute))
                image_.text[it.name()] = text->value();
            else if (const auto* f = dynamic_cast<const Imf::FloatAttribute*>(&attribute))
                image_.numbers[it.name()] = f->value();
            else if (const auto* d = dynamic_cast<const Imf::DoubleAttribute*>(&attribute))
                image_.numbers[it.name()] = d->value();
            else if (const auto* i = dynamic_cast<const Imf::IntAttribute*>(&attribute))
                image_.numbers[it.name()] = i->value();
            else if (const auto* m44f = dynamic_cast<const Imf::M44fAttribute*>(&attribute))
                keep_matrix(it.name(), m44f->value());
            else if (const auto* m44d = dynamic_cast<const Imf::M44dAttribute*>(&attribute))
                keep_matrix(it.name(), m44d->value());
        }
    }

    void read_channels(Imf::MultiPartInputFile& file, const Imf::ChannelList& channels)
    {
        for (auto it = channels.begin(); it != channels.end(); ++it) {
            require(it.channel().xSampling == 1 && it.channel().ySampling == 1,
                    "{}: channel {} is subsampled (save it at full resolution)", name_,
                    exr_detail::one_line(it.name()));
            image_.channels.push_back({it.name(), std::vector<float>(data_width() * data_height())});
        }
        Imf::FrameBuffer buffer;
        for (Channel& channel : image_.channels)
            buffer.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, channel.pixels.data(), data_));
        Imf::InputPart part(file, 0);
        part.setFrameBuffer(buffer);
        part.readPixels(data_.min.y, data_.max.y);
        for (Channel& channel : image_.channels)
            fit_to_display(channel.pixels);

        const Channel* y = image_.find("Y");
        if (y && !image_.find("R") && !image_.find("G") && !image_.find("B")) {
            const std::vector<float> grey = y->pixels;
            std::erase_if(image_.channels, [](const Channel& c) { return c.name == "Y"; });
            for (const char* name : {"R", "G", "B"})
                image_.channels.push_back({name, grey});
        }
    }

    /// Chroma is stored at half resolution: the library rebuilds it with its own filter, in half precision.
    void read_luminance_chroma()
    {
        stream_.seekg(0);
        Imf::RgbaInputFile file(stream_, exr_detail::threads());
        std::vector<Imf::Rgba> pixels(data_width() * data_height());
        const Imf::Slice origin = Imf::Slice::Make(Imf::HALF, pixels.data(), data_, sizeof(Imf::Rgba));
        file.setFrameBuffer(reinterpret_cast<Imf::Rgba*>(origin.base), 1, data_width());
        file.readPixels(data_.min.y, data_.max.y);
        const auto keep = [&](const char* name, half Imf::Rgba::*value) {
            std::vector<float> values(pixels.size());
            std::transform(pixels.begin(), pixels.end(), values.begin(),
                           [&](const Imf::Rgba& p) { return static_cast<float>(p.*value); });
            fit_to_display(values);
            image_.channels.push_back({name, std::move(values)});
        };
        keep("R", &Imf::Rgba::r);
        keep("G", &Imf::Rgba::g);
        keep("B", &Imf::Rgba::b);
        if (file.channels() & Imf::WRITE_A)
            keep("A", &Imf::Rgba::a);
    }

    void fit_to_display(std::vector<float>& pixels) const
    {
        if (data_ == display_)
            return;
        std::vector<float> shown(static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height));
        const int x_begin = std::max(data_.min.x, display_.min.x), x_end = std::min(data_.max.x, display_.max.x) + 1;
        const int y_begin = std::max(data_.min.y, display_.min.y), y_end = std::min(data_.max.y, display_.max.y) + 1;
        for (int y = y_begin; y < y_end; ++y) {
            const auto from =
                pixels.begin() + std::ptrdiff_t{y - data_.min.y} * static_cast<std::ptrdiff_t>(data_width());
            const auto to = shown.begin() + std::ptrdiff_t{y - display_.min.y} * image_.width;
            std::copy(from + (x_begin - data_.min.x), from + (x_end - data_.min.x), to + (x_begin - display_.min.x));
        }
        pixels = std::move(shown);
    }

    std::size_t data_width() const { return static_cast<std::size_t>(data_.max.x - data_.min.x + 1); }
    std::size_t data_height() const { return static_cast<std::size_t>(data_.max.y - data_.min.y + 1); }

    Imf::IStream& stream_;
    std::string name_;
    Imath::Box2i data_, display_;
    Image image_;
};

Image read_exr(Imf::IStream& stream, std::uint64_t bytes, const std::string& name)
{
    try {
        exr_detail::check_headers(stream, bytes, name);
        stream.seekg(0);
        return Reader(stream, name).read();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        fail("{}: not enough memory to read it (use a smaller image)", name);
    } catch (const std::exception& e) {
        fail("{}: cannot be read as OpenEXR: {} (the file is broken or truncated: get it again)", name,
             exr_detail::one_line(e.what()));
    }
}

} // namespace

Image read_exr(const std::filesystem::path& path)
{
    std::error_code error;
    const bool is_file = std::filesystem::is_regular_file(path, error);
    require(is_file, "{}: no such file (check the name)", path.string());
    std::ifstream file(path, std::ios::binary);
    require(file.is_open(), "{}: cannot be opened (check its permissions)", path.string());
    const std::uint64_t bytes = std::filesystem::file_size(path, error);
    require(!error, "{}: {} (check the file)", path.string(), error.message());
    Imf::StdIFStream stream(file, path.c_str());
    return read_exr(stream, bytes, path.string());
}

Image read_exr(std::span<const std::byte> bytes, const std::string& name)
{
    MemoryStream stream(bytes, name);
    return read_exr(stream, bytes.size(), name);
}

} // namespace lumisweep

#include "lumisweep/image/exr.h"

#include <cmath>
#include <limits>
#include <random>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include "lumisweep/base/memory.h"
#include "scratch_folder.h"

namespace lumisweep {
namespace {

Image layered(int width, int height)
{
    std::mt19937 random(2);
    std::normal_distribution<float> normal(0.0F, 100.0F);
    Image image;
    image.width = width;
    image.height = height;
    for (const char* name : {"R", "G", "B", "A", "Variance.R", "depth.Z", "normal.X"}) {
        image.channels.push_back({name, std::vector<float>(static_cast<std::size_t>(width * height))});
        for (float& value : image.channels.back().pixels)
            value = normal(random);
    }
    image.channels[5].pixels[3] = std::numeric_limits<float>::infinity();
    return image;
}

TEST(Exr, GivesBackWhatWasWritten)
{
    const ScratchFolder folder;
    for (const auto& [width, height] : {std::pair{1, 1}, {37, 19}, {128, 64}}) {
        Image image = layered(std::max(width, 4), height);
        image.text = {{"strategy", "two-step"}, {"scene", "{\n  \"version\": 1\n}\n"}, {"empty", ""}};
        image.numbers = {{"samplesPerPixel", 64.0}, {"renderSeconds", 12.345678901234}, {"seed", 4294967295.0}};
        image.matrices["worldToCamera"] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
        write_exr(folder / "image.exr", image);
        const Image back = read_exr(folder / "image.exr");
        EXPECT_EQ(back.width, image.width);
        EXPECT_EQ(back.height, image.height);
        ASSERT_EQ(back.channels.size(), image.channels.size());
        for (const Channel& channel : image.channels) {
            ASSERT_TRUE(back.find(channel.name)) << channel.name;
            EXPECT_EQ(back.find(channel.name)->pixels, channel.pixels) << channel.name;
        }
        EXPECT_EQ(back.text, image.text);
        EXPECT_EQ(back.numbers, image.numbers);
        EXPECT_EQ(back.matrices, image.matrices);
        const Bytes bytes = read_all(folder / "image.exr");
        EXPECT_EQ(read_exr(bytes, "memory").find("Variance.R")->pixels, image.find("Variance.R")->pixels);
        // Writing again what was read works too: structural attributes do not leak into the image's own.
        write_exr(folder / "again.exr", back);
        EXPECT_EQ(read_exr(folder / "again.exr").numbers, image.numbers);
    }
    EXPECT_EQ(folder.count_files(), 2U); // no temporary files stay
}

/// A file by OpenEXR itself: channel "R" counts pixels along x + 100 y in data-window coordinates.
template <class File, class... More>
void write_ramp(const std::filesystem::path& path, Imf::Header header, Imf::PixelType type, const More&... more)
{
    const Imath::Box2i window = header.dataWindow();
    const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    std::vector<float> floats;
    std::vector<half> halves;
    std::vector<unsigned> uints;
    for (int y = window.min.y; y <= window.max.y; ++y) {
        for (int x = window.min.x; x <= window.max.x; ++x) {
            const int value = 1000 + x + 100 * y;
            floats.push_back(static_cast<float>(value));
            halves.push_back(half(static_cast<float>(value)));
            uints.push_back(static_cast<unsigned>(value));
        }
    }
    const void* data = type == Imf::FLOAT  ? static_cast<const void*>(floats.data())
                       : type == Imf::HALF ? static_cast<const void*>(halves.data())
                                           : static_cast<const void*>(uints.data());
    Imf::FrameBuffer buffer;
    for (const char* name : {"R", "G", "B"}) {
        header.channels().insert(name, Imf::Channel(type));
        buffer.insert(name, Imf::Slice::Make(type, data, window));
    }
    File file(path.c_str(), header, more...);
    file.setFrameBuffer(buffer);
    if constexpr (std::is_same_v<File, Imf::OutputFile>)
        file.writePixels(height);
    else
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    ASSERT_GT(width, 0);
}

TEST(Exr, ReadsAllTypesCompressionsAndTilings)
{
    const ScratchFolder folder;
    for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
        for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
            for (const bool tiled : {false, true}) {
                Imf::Header header(9, 5);
                header.compression() = static_cast<Imf::Compression>(compression);
                const std::filesystem::path path = folder / "ramp.exr";
                if (tiled) {
                    header.setTileDescription(Imf::TileDescription(4, 4));
                    write_ramp<Imf::TiledOutputFile>(path, header, type);
                } else {
                    write_ramp<Imf::OutputFile>(path, header, type);
                }
                const Image image = read_exr(path);
                ASSERT_EQ(image.width, 9);
                ASSERT_EQ(image.height, 5);
                for (int y = 0; y < 5; ++y)
                    for (int x = 0; x < 9; ++x)
                        EXPECT_NEAR(image.find("R")->pixels[static_cast<std::size_t>(9 * y + x)], 1000 + x + 100 * y,
                                    compression >= Imf::PXR24_COMPRESSION ? 40 : 0) // the lossy ones
                            << "type " << type << " compression " << compression << " tiled " << tiled;
            }
        }
    }
}

TEST(Exr, ReadsTheFirstOfSeveralParts)
{
    const ScratchFolder folder;
    const std::filesystem::path path = folder / "parts.exr";
    {
        Imf::Header first(6, 4), second(Imath::Box2i({0, 0}, {5, 3}), Imath::Box2i({0, 0}, {2, 1}));
        first.setName("first");
        second.setName("second");
        first.setType(Imf::SCANLINEIMAGE);
        second.setType(Imf::SCANLINEIMAGE);
        for (Imf::Header* header : {&first, &second})
            header->channels().insert("R", Imf::Channel(Imf::FLOAT));
        const Imf::Header headers[] = {first, second};
        Imf::MultiPartOutputFile file(path.c_str(), headers, 2);
        for (int i = 0; i < 2; ++i) {
            const std::vector<float> pixels(24, 7.0F + static_cast<float>(i));
            Imf::FrameBuffer buffer;
            buffer.insert("R", Imf::Slice::Make(Imf::FLOAT, pixels.data(), headers[i].dataWindow()));
            Imf::OutputPart part(file, i);
            part.setFrameBuffer(buffer);
            part.writePixels(i == 0 ? 4 : 2);
        }
    }
    const Image image = read_exr(path);
    EXPECT_EQ(image.width, 6);
    EXPECT_EQ(image.height, 4);
    EXPECT_EQ(image.find("R")->pixels, std::vector<float>(24, 7.0F));
}

TEST(Exr, FillsTheDisplayWindow)
{
    const ScratchFolder folder;
    // Display 0…7 × 0…3, data −2…4 × 1…9: cropped at the left and below, empty at the right and above.
    Imf::Header header(Imath::Box2i({0, 0}, {7, 3}), Imath::Box2i({-2, 1}, {4, 9}));
    write_ramp<Imf::OutputFile>(folder / "crop.exr", header, Imf::FLOAT);
    const Image image = read_exr(folder / "crop.exr");
    ASSERT_EQ(image.width, 8);
    ASSERT_EQ(image.height, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 8; ++x)
            EXPECT_EQ(image.find("G")->pixels[static_cast<std::size_t>(8 * y + x)],
                      x <= 4 && y >= 1 ? static_cast<float>(1000 + x + 100 * y) : 0.0F)
                << x << ' ' << y;
    Imf::Header apart(Imath::Box2i({0, 0}, {7, 3}), Imath::Box2i({20, 1}, {24, 9}));
    write_ramp<Imf::OutputFile>(folder / "apart.exr", apart, Imf::FLOAT);
    expect_one_line_error("apart.exr", [&] { read_exr(folder / "apart.exr"); });
}

TEST(Exr, ReadsLuminanceAloneAndWithChroma)
{
    const ScratchFolder folder;
    std::vector<Imf::Rgba> pixels(16 * 8, Imf::Rgba(2.0F, 1.0F, 0.5F, 1.0F));
    for (const Imf::RgbaChannels channels : {Imf::WRITE_Y, Imf::WRITE_YC, Imf::WRITE_YCA}) {
        const std::filesystem::path path = folder / "luminance.exr";
        {
            Imf::RgbaOutputFile file(path.c_str(), 16, 8, channels);
            file.setYCRounding(10, 10); // keep all of half's digits
            file.setFrameBuffer(pixels.data(), 1, 16);
            file.writePixels(8);
        }
        const Image image = read_exr(path);
        ASSERT_TRUE(image.find("R") && image.find("G") && image.find("B"));
        EXPECT_EQ(image.find("Y"), nullptr);
        EXPECT_EQ(image.find("A") != nullptr, channels == Imf::WRITE_YCA);
        const float y = 0.2126F * 2.0F + 0.7152F + 0.0722F * 0.5F;
        const bool grey = channels == Imf::WRITE_Y;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            ASSERT_NEAR(image.find("R")->pixels[i], grey ? y : 2.0F, 6e-3);
            ASSERT_NEAR(image.find("G")->pixels[i], grey ? y : 1.0F, 6e-3);
            ASSERT_NEAR(image.find("B")->pixels[i], grey ? y : 0.5F, 6e-3);
        }
    }
}

TEST(Exr, WritingFailsWithOneLineAndLeavesNothing)
{
    const ScratchFolder folder;
    const Image image = layered(8, 4);
    write_exr(folder / "kept.exr", image);
    const Bytes before = read_all(folder / "kept.exr");
    const auto refused = [&](auto change) {
        Image bad = image;
        change(bad);
        expect_one_line_error("kept.exr", [&] { write_exr(folder / "kept.exr", bad); });
    };
    refused([](Image& i) { i.channels[0].pixels.pop_back(); });
    refused([](Image& i) { i.channels[1].name = "R"; });
    refused([](Image& i) { i.channels[1].name = ""; });
    refused([](Image& i) { i.channels.clear(); });
    refused([](Image& i) { i.width = 0; });
    refused([](Image& i) { i.matrices["m"] = {1, 2, 3}; });
    refused([](Image& i) { i.numbers["dataWindow"] = 1; });
    refused([](Image& i) { i.text["twice"] = "a", i.numbers["twice"] = 1; });
    EXPECT_EQ(read_all(folder / "kept.exr"), before);
    EXPECT_EQ(folder.count_files(), 1U);
    expect_one_line_error("absent", [&] { write_exr(folder / "absent/image.exr", image); });
    std::filesystem::create_directory(folder / "taken.exr");
    expect_one_line_error("taken.exr", [&] { write_exr(folder / "taken.exr", image); });
    EXPECT_EQ(folder.count_files(), 2U);
}

/// Overwrites an int after the first occurrence of an attribute's name, type and size.
Bytes with_box(Bytes bytes, const std::string& attribute, const std::vector<std::int32_t>& box)
{
    const Bytes key = bytes_of(attribute + std::string(1, '\0') + "box2i" + std::string(1, '\0'));
    auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
    EXPECT_NE(at, bytes.end());
    at += static_cast<std::ptrdiff_t>(key.size()) + 4;
    for (const std::int32_t value : box)
        for (int shift = 0; shift < 32; shift += 8)
            *at++ = static_cast<std::byte>(static_cast<std::uint32_t>(value) >> shift);
    return bytes;
}

TEST(Exr, HostileFilesFailWithOneLine)
{
    const ScratchFolder folder;
    write_exr(folder / "sound.exr", layered(64, 48));
    const Bytes sound = read_all(folder / "sound.exr");
    constexpr std::int32_t huge = std::numeric_limits<std::int32_t>::max(),
                           low = std::numeric_limits<std::int32_t>::min();
    std::vector<Bytes> corpus{
        {}, bytes_of("v/1"), bytes_of("not an image at all"), Bytes(1000), Bytes(5000, std::byte{0xff})};
    for (const std::size_t size : {4, 8, 20, 100, 300, 400, 700, 2000, 10000})
        corpus.emplace_back(sound.begin(),
                            sound.begin() + static_cast<std::ptrdiff_t>(std::min(size, sound.size() - 1)));
    const std::vector<std::vector<std::int32_t>> impossible{{0, 0, huge, huge},    {low, low, huge, huge},
                                                            {0, 0, -1, -1},        {5, 5, 4, 4},
                                                            {0, 0, 65535, 200000}, {huge, huge, huge, huge}};
    for (const std::vector<std::int32_t>& box : impossible) {
        corpus.push_back(with_box(sound, "dataWindow", box));
        corpus.push_back(with_box(sound, "displayWindow", box));
    }
    for (const std::vector<std::int32_t>& lie : {std::vector<std::int32_t>{0, 0, 63, 30000}, {0, 0, 60000, 47}})
        corpus.push_back(with_box(sound, "dataWindow", lie));
    if (available_memory() < (std::uint64_t{64} << 30)) // 120 GB: refused before they are taken
        corpus.push_back(with_box(sound, "displayWindow", {0, 0, 65535, 65535}));
    std::mt19937 random(8);
    Bytes noise(4000);
    for (std::byte& b : noise)
        b = static_cast<std::byte>(random());
    corpus.push_back(noise);
    std::copy(sound.begin(), sound.begin() + 8, noise.begin()); // a sound magic number, then noise
    corpus.push_back(noise);
    for (std::size_t i = 0; i < corpus.size(); ++i) {
        SCOPED_TRACE(i);
        expect_one_line_error("memory", [&] { read_exr(corpus[i], "memory"); });
        write_all(folder / "hostile.exr", corpus[i]);
        expect_one_line_error("hostile.exr", [&] { read_exr(folder / "hostile.exr"); });
    }
    expect_one_line_error("absent.exr", [&] { read_exr(folder / "absent.exr"); });
    expect_one_line_error("lumisweep", [&] { read_exr(folder / ""); });
    try_damaged_copies(sound, [](const Bytes& bytes) { read_exr(bytes, "memory"); });
}

TEST(Exr, DoesNotTakeTheMemoryThatAnAttributeClaims)
{
    const ScratchFolder folder;
    Image image = layered(8, 4);
    image.text["note"] = "x";
    write_exr(folder / "sound.exr", image);
    Bytes bytes = read_all(folder / "sound.exr");
    const Bytes key = bytes_of(std::string("note\0string\0", 12));
    const auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
    ASSERT_NE(at, bytes.end());
    *(at + 12 + 3) = std::byte{0x7f}; // little-endian: 2 GB
    expect_one_line_error("attribute 'note' claims", [&] { read_exr(bytes, "memory"); });
    *(at + 12 + 3) = std::byte{0xff};
    expect_one_line_error("attribute 'note' claims", [&] { read_exr(bytes, "memory"); });
}

TEST(Exr, ReadsPhotographedSkies)
{
    const std::filesystem::path environments = std::filesystem::path(LUMISWEEP_FETCHED_DATA) / "environments";
    if (!std::filesystem::exists(environments))
        GTEST_SKIP() << "no fetched data in " << environments;
    int maps = 0;
    for (const auto& entry : std::filesystem::directory_iterator(environments)) {
        if (entry.path().extension() != ".exr")
            continue;
        const Image image = read_exr(entry.path());
        EXPECT_EQ(image.width, 2 * image.height) << entry.path();
        double sum = 0;
        for (const float value : image.find("G")->pixels)
            sum += value;
        EXPECT_GT(sum, 0.0) << entry.path();
        ++maps;
    }
    EXPECT_GT(maps, 0);
}

} // namespace
} // namespace lumisweep

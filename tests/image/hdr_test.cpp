#include "lumisweep/image/hdr.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "lumisweep/image/exr.h"
#include "scratch_folder.h"

namespace lumisweep {
namespace {

std::string header(int width, int height, const std::string& lines = "")
{
    return "#?RADIANCE\n# by hand\n" + lines + "FORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " +
           std::to_string(width) + "\n";
}

std::string rgbe(int r, int g, int b, int e)
{
    return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(e)};
}

Image read(const std::string& text) { return read_hdr(bytes_of(text), "memory"); }

TEST(Hdr, ReadsFlatPixels)
{
    // 2⁰ = mantissa 128, exponent 129; row 0 is the top.
    const Image image = read(header(2, 2) + rgbe(128, 64, 0, 129) + rgbe(200, 100, 50, 120) + rgbe(1, 2, 3, 255) +
                             rgbe(255, 255, 255, 0));
    ASSERT_EQ(image.width, 2);
    ASSERT_EQ(image.height, 2);
    const std::array<std::array<float, 4>, 3> expected{{{1.0F, std::ldexp(200.0F, -16), std::ldexp(1.0F, 119), 0.0F},
                                                        {0.5F, std::ldexp(100.0F, -16), std::ldexp(2.0F, 119), 0.0F},
                                                        {0.0F, std::ldexp(50.0F, -16), std::ldexp(3.0F, 119), 0.0F}}};
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(image.channels[c].name, std::string(1, "RGB"[c]));
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_EQ(image.channels[c].pixels[i], expected[c][i]);
    }
}

TEST(Hdr, ReadsNewRunLengthCodes)
{
    // Ten pixels: red a run of 10, green 10 single ones, blue 4 + 6, exponent a run of 10.
    std::string row = {2, 2, 0, 10};
    row += {static_cast<char>(138), 64};
    row += {10, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    row += {4, 9, 8, 7, 6, static_cast<char>(134), 5};
    row += {static_cast<char>(138), static_cast<char>(136)};
    const Image image = read(header(10, 2) + row + row);
    for (std::size_t i = 0; i < 20; ++i) {
        const std::size_t x = i % 10;
        EXPECT_EQ(image.find("R")->pixels[i], 64.0F);
        EXPECT_EQ(image.find("G")->pixels[i], static_cast<float>(x));
        EXPECT_EQ(image.find("B")->pixels[i], x < 4 ? 9.0F - static_cast<float>(x) : 5.0F);
    }
}

TEST(Hdr, ReadsOldRunLengthCodes)
{
    // A pixel, repeated 3 + 1 · 256 times, then another.
    const Image image =
        read(header(261, 1) + rgbe(7, 8, 9, 136) + rgbe(1, 1, 1, 3) + rgbe(1, 1, 1, 1) + rgbe(50, 60, 70, 136));
    for (std::size_t i = 0; i < 260; ++i)
        ASSERT_EQ(image.find("G")->pixels[i], 8.0F) << i;
    EXPECT_EQ(image.find("G")->pixels[260], 60.0F);
    // Flat files may hold (2, 2, …) rows that are too short for the new coding.
    EXPECT_EQ(read(header(1, 1) + rgbe(2, 2, 0, 136)).find("R")->pixels[0], 2.0F);
}

TEST(Hdr, DividesExposureOut)
{
    const std::string pixel = rgbe(100, 50, 25, 136);
    EXPECT_EQ(read(header(1, 1, "EXPOSURE=4\n") + pixel).find("R")->pixels[0], 25.0F);
    EXPECT_EQ(read(header(1, 1, "EXPOSURE= 2.0 \nGAMMA=1\nEXPOSURE=0.5\r\n") + pixel).find("R")->pixels[0], 100.0F);
}

TEST(Hdr, HostileFilesFailWithOneLine)
{
    const std::string pixels(4 * 16 * 8, '\x42');
    std::vector<std::string> corpus{
        "",
        "#",
        "#?",
        "#?RADIANCE\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n",
        "#?RADIANCE\n" + std::string(100000, 'x'),
        "BM" + pixels,
        "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 8 +X 16\n" + pixels,
        "#?RADIANCE\nEXPOSURE=0\n\n-Y 8 +X 16\n" + pixels,
        "#?RADIANCE\nEXPOSURE=nan\n\n-Y 8 +X 16\n" + pixels,
        "#?RADIANCE\nEXPOSURE=1e300\nEXPOSURE=1e300\n\n-Y 8 +X 16\n" + pixels,
        header(16, 9) + pixels,
        header(17, 8) + pixels,
        header(16, 8) + pixels.substr(1),
        header(0, 8) + pixels,
        header(-16, 8) + pixels,
        header(65536, 65536) + pixels,
        header(2000000000, 2000000000) + pixels,
        header(8, 1) + std::string{2, 2, 0, 9} + pixels,
        header(8, 1) + std::string{2, 2, 0, 8, static_cast<char>(137), 1} + pixels,
        header(8, 1) + std::string{2, 2, 0, 8, 0, 1} + pixels,
        header(8, 1) + std::string{2, 2, 0, 8, 9, 1} + pixels,
        header(8, 1) + rgbe(1, 1, 1, 2) + pixels,
        header(8, 1) + rgbe(5, 5, 5, 5) + rgbe(1, 1, 1, 8) + pixels,
        header(70000, 1) + rgbe(5, 5, 5, 5) + rgbe(1, 1, 1, 0) + rgbe(1, 1, 1, 0) + rgbe(1, 1, 1, 0) + rgbe(1, 1, 1, 1),
    };
    for (const char* resolution :
         {"+Y 8 +X 16", "-Y 8 -X 16", "+X 16 -Y 8", "-Y 8", "-Y 8 +X 16 3", "-Y 8x +X 16", "8 16"})
        corpus.push_back("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + std::string(resolution) + "\n" + pixels);
    for (std::size_t i = 0; i < corpus.size(); ++i) {
        SCOPED_TRACE(i);
        expect_one_line_error("memory", [&] { read(corpus[i]); });
    }
    std::string sound = header(16, 8);
    for (int row = 0; row < 8; ++row)
        sound += std::string{2,
                             2,
                             0,
                             16,
                             static_cast<char>(144),
                             64,
                             static_cast<char>(144),
                             65,
                             static_cast<char>(144),
                             66,
                             static_cast<char>(144),
                             static_cast<char>(128)};
    EXPECT_NO_THROW(read(sound));
    try_damaged_copies(bytes_of(sound), [](const Bytes& bytes) { read_hdr(bytes, "memory"); });
}

TEST(LoadLatLong, GoesByTheBytesNotTheName)
{
    const ScratchFolder folder;
    write_all(folder / "radiance.exr", bytes_of(header(1, 1) + rgbe(100, 50, 25, 136)));
    EXPECT_EQ(load_latlong(folder / "radiance.exr").find("G")->pixels[0], 50.0F);
    Image image;
    image.width = image.height = 1;
    image.channels = {{"Y", {3.0F}}};
    write_exr(folder / "open.hdr", image);
    EXPECT_EQ(load_latlong(folder / "open.hdr").find("B")->pixels[0], 3.0F);
    image.channels = {{"R", {3.0F}}, {"G", {3.0F}}};
    write_exr(folder / "no-blue.exr", image);
    expect_one_line_error("no-blue.exr", [&] { load_latlong(folder / "no-blue.exr"); });
    write_all(folder / "empty.exr", {});
    expect_one_line_error("empty.exr", [&] { load_latlong(folder / "empty.exr"); });
    write_all(folder / "text.hdr", bytes_of("hello, world"));
    expect_one_line_error("text.hdr", [&] { load_latlong(folder / "text.hdr"); });
    expect_one_line_error("absent.hdr", [&] { load_latlong(folder / "absent.hdr"); });
    expect_one_line_error("absent.hdr", [&] { read_hdr(folder / "absent.hdr"); });
}

} // namespace
} // namespace lumisweep

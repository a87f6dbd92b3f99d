#include "lumisweep/image/tonemap.h"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <png.h>

#include "lumisweep/image/png.h"
#include "scratch_folder.h"

namespace lumisweep {
namespace {

Image image_of(int width, const std::vector<std::array<float, 4>>& rgba)
{
    Image image;
    image.width = width;
    image.height = static_cast<int>(rgba.size()) / width;
    for (std::size_t c = 0; c < 4; ++c) {
        image.channels.push_back({std::string(1, "RGBA"[c]), {}});
        for (const auto& pixel : rgba)
            image.channels[c].pixels.push_back(pixel[c]);
    }
    return image;
}

TEST(ToneMap, FollowsItsFormula)
{

    const Image image = image_of(2, {{0.5F, 0.5F, 0.5F, 1}, {4, 4, 4, 1}});
    ToneMapSettings settings;
    settings.exposure = 0.5;
    // The 99.9th percentile of two pixels is the smaller: white is 1 by its lower limit, 0.25 · 1.25 / 1.25 = 0.25.
    const DisplayImage out = tone_map(image, settings);
    EXPECT_EQ(out.channels, 3);
    EXPECT_EQ(out.pixels[0], 137); // sRGB(0.25) = 0.53710
    EXPECT_EQ(out.pixels[3], 255);
}

TEST(ToneMap, ExposureBringsTheLogAverageToAQuarter)
{
    const Image image = image_of(4, {{1, 1, 1, 1}, {4, 4, 4, 1}, {16, 16, 16, 1}, {0, 0, 0, 1}});
    EXPECT_NEAR(automatic_exposure(image, Background::opaque), 0.25 / 4, 1e-12);
    EXPECT_EQ(automatic_exposure(image_of(1, {{0, 0, 0, 0}}), Background::transparent), 1.0);
    // Scaling the light changes nothing.
    Image brighter = image;
    for (std::size_t c = 0; c < 3; ++c)
        for (float& value : brighter.channels[c].pixels)
            value *= 1024.0F;
    EXPECT_EQ(tone_map(image, {}).pixels, tone_map(brighter, {}).pixels);
}

TEST(ToneMap, IsMonotonicAndKeepsHue)
{
    std::vector<std::array<float, 4>> ramp;
    for (int i = 0; i < 2000; ++i) {
        const float l = std::exp(0.01F * static_cast<float>(i - 1000));
        ramp.push_back({l, 0.5F * l, 0.25F * l, 1});
    }
    const DisplayImage out = tone_map(image_of(2000, ramp), {});
    for (std::size_t i = 0; i < 2000; ++i) {
        EXPECT_GE(out.pixels[3 * i], out.pixels[3 * i + 1]);
        EXPECT_GE(out.pixels[3 * i + 1], out.pixels[3 * i + 2]);
        if (i > 0) {
            EXPECT_GE(out.pixels[3 * i + 1], out.pixels[3 * i - 2]);
        }
    }
    EXPECT_EQ(out.pixels[0], 0);
    EXPECT_EQ(out.pixels[3 * 1999 + 2], 255);
}

TEST(ToneMap, AlphaIsStraightWhereNothingIsBehind)
{
    const Image image = image_of(3, {{0.4F, 0.4F, 0.4F, 1}, {0.1F, 0.1F, 0.1F, 0.25F}, {0, 0, 0, 0}});
    ToneMapSettings settings;
    settings.exposure = 1.0;
    EXPECT_EQ(tone_map(image, settings).channels, 3);
    settings.background = Background::transparent;
    const DisplayImage out = tone_map(image, settings);
    ASSERT_EQ(out.channels, 4);
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_EQ(out.pixels[4 + c], out.pixels[c]); // the same colour, a quarter of the coverage
    EXPECT_EQ(out.pixels[3], 255);
    EXPECT_EQ(out.pixels[7], 64);
    EXPECT_EQ(out.pixels[11], 0);
    EXPECT_EQ(tone_map(image_of(1, {{1, 1, 1, 1}}), settings).channels, 3);
}

TEST(ToneMap, ShowsBrokenPixelsAsBlackAndRefusesBrokenImages)
{
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const DisplayImage out = tone_map(
        image_of(4, {{nan, nan, nan, 1}, {infinity, infinity, infinity, 1}, {-5, -5, -5, 1}, {1, 1, 1, 1}}), {});
    for (std::size_t i = 0; i < 9; ++i)
        EXPECT_EQ(out.pixels[i], 0);
    EXPECT_GT(out.pixels[9], 100);
    const DisplayImage large = tone_map(image_of(1, {{3e38F, 3e38F, 3e38F, 1e-3F}}), {{}, Background::transparent});
    EXPECT_GT(large.pixels[0], 100);
    Image no_blue = image_of(1, {{1, 1, 1, 1}});
    no_blue.channels.erase(no_blue.channels.begin() + 2);
    EXPECT_THROW(tone_map(no_blue, {}), Error);
    Image small = image_of(1, {{1, 1, 1, 1}});
    small.height = 2;
    EXPECT_THROW(tone_map(small, {}), Error);
    ToneMapSettings settings;
    settings.exposure = -1.0;
    EXPECT_THROW(tone_map(image_of(1, {{1, 1, 1, 1}}), settings), Error);
}

TEST(ToneMap, ARenderIsShownBetweenItsVolumeAndItsBackground)
{
    const Image image = image_of(4, {{0.1F, 0.1F, 0.1F, 1}, {0.1F, 0.1F, 0.1F, 1}, {4, 4, 4, 0}, {4, 4, 4, 0}});
    const double volume = automatic_exposure(image, Background::transparent);
    const double whole = automatic_exposure(image, Background::opaque);
    EXPECT_GT(volume, whole);
    const ToneMapSettings opaque = display_settings(image, Background::opaque);
    EXPECT_EQ(opaque.background, Background::opaque);
    EXPECT_NEAR(opaque.exposure.value(), std::sqrt(volume * whole), 1e-12);
    const ToneMapSettings transparent = display_settings(image, Background::transparent);
    EXPECT_EQ(transparent.background, Background::transparent);
    EXPECT_FALSE(transparent.exposure.has_value());
}

TEST(Png, GivesBackWhatWasWritten)
{
    const ScratchFolder folder;
    for (const int channels : {3, 4}) {
        DisplayImage image{5, 3, channels, {}};
        for (int i = 0; i < 15 * channels; ++i)
            image.pixels.push_back(static_cast<std::uint8_t>(37 * i + 11));
        const std::filesystem::path path = folder / "image.png";
        write_png(path, image);
        png_image png{};
        png.version = PNG_IMAGE_VERSION;
        ASSERT_TRUE(png_image_begin_read_from_file(&png, path.c_str()));
        EXPECT_EQ(png.width, 5U);
        EXPECT_EQ(png.height, 3U);
        EXPECT_EQ((png.format & PNG_FORMAT_FLAG_ALPHA) != 0, channels == 4);
        png.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
        std::vector<std::uint8_t> back(image.pixels.size());
        ASSERT_TRUE(png_image_finish_read(&png, nullptr, back.data(), 0, nullptr));
        EXPECT_EQ(back, image.pixels);
    }
    EXPECT_EQ(folder.count_files(), 1U);
    expect_one_line_error("bad.png", [&] { write_png(folder / "bad.png", DisplayImage{2, 2, 3, {1, 2}}); });
    expect_one_line_error("bad.png", [&] { write_png(folder / "bad.png", DisplayImage{}); });
    expect_one_line_error("absent", [&] { write_png(folder / "absent/a.png", DisplayImage{1, 1, 3, {1, 2, 3}}); });
}

} // namespace
} // namespace lumisweep

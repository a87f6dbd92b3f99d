#include "lumisweep/image/compare.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "scratch_folder.h"

namespace lumisweep {
namespace {

Image grey(std::vector<float> values)
{
    Image image;
    image.width = static_cast<int>(values.size());
    image.height = 1;
    for (const char* name : {"R", "G", "B"})
        image.channels.push_back({name, values});
    return image;
}

TEST(Compare, MeasuresByHand)
{
    Image image = grey({1.0F, 3.0F});
    image.channels[2].pixels = {2.0F, 3.0F};
    const Comparison result = compare_images(image, grey({2.0F, 3.0F}));
    EXPECT_NEAR(result.mse, 2.0 / 6, 1e-15);
    EXPECT_NEAR(result.rmse, std::sqrt(2.0 / 6), 1e-15);
    EXPECT_NEAR(result.relmse, 2.0 / 4.01 / 6, 1e-15);
    EXPECT_NEAR(result.psnr, 10 * std::log10(9.0 / (2.0 / 6)), 1e-12);
    EXPECT_NEAR(result.mean_image, 13.0 / 6, 1e-15);
    EXPECT_NEAR(result.mean_reference, 2.5, 1e-15);
}

TEST(Compare, EqualImagesDifferByNothing)
{
    const Comparison result = compare_images(grey({1.0F, 3.0F}), grey({1.0F, 3.0F}));
    EXPECT_EQ(result.mse, 0.0);
    EXPECT_EQ(result.relmse, 0.0);
    EXPECT_EQ(result.psnr, std::numeric_limits<double>::infinity());
}

TEST(Compare, RefusesWhatCannotBeCompared)
{
    const Image sound = grey({1.0F, 3.0F});
    expect_one_line_error("reference", [&] { compare_images(sound, grey({1.0F})); });
    expect_one_line_error("empty", [&] { compare_images(grey({}), grey({})); });
    Image no_green = sound;
    no_green.channels.erase(no_green.channels.begin() + 1);
    expect_one_line_error("channel G", [&] { compare_images(no_green, sound); });
    Image broken = grey({1.0F, std::numeric_limits<float>::quiet_NaN()});
    broken.channels[0].pixels[0] = std::numeric_limits<float>::infinity();
    expect_one_line_error("2 of the 2 pixels of the reference", [&] { compare_images(sound, broken); });
    broken.channels[0].pixels.pop_back();
    expect_one_line_error("channel R of the image", [&] { compare_images(broken, sound); });
}

} // namespace
} // namespace lumisweep

// When renders end, on films that are filled by hand.
#include "lumisweep/render/stopping.h"

#include <gtest/gtest.h>

#include <vector>

namespace lumisweep {
namespace {

/// One pixel, a sample a call.
class OnePixel {
public:
    OnePixel() : film(1, 1), color_(3), features_(feature_count) {}
    void add(float luminance)
    {
        for (float& c : color_)
            c = luminance;
        film.add({color_.data(), features_.data()});
    }
    void add(int count, float luminance)
    {
        for (int i = 0; i < count; ++i)
            add(luminance);
    }
    Film film;

private:
    std::vector<float> color_, features_;
};

TEST(Stopping, SamplesCountWhatTheFilmHolds)
{
    OnePixel pixel;
    pixel.add(3, 1.0F);
    Stopping stopping(StopSamples{5}, pixel.film);
    EXPECT_FALSE(stopping.met(100.0));
    EXPECT_EQ(stopping.progress(1.0).fraction, 0.0);
    pixel.add(1.0F);
    const RenderProgress half = stopping.progress(2.0);
    EXPECT_EQ(half.fraction, 0.5);
    EXPECT_EQ(half.remaining_s, 2.0);
    pixel.add(1.0F);
    EXPECT_TRUE(stopping.met(0.0));
}

TEST(Stopping, TimeEndsBeforeAPassThatWouldEndTooLate)
{
    OnePixel pixel;
    Stopping stopping(StopTime{1.0}, pixel.film);
    EXPECT_FALSE(stopping.met(9.0)); // an empty film is no image
    pixel.add(1.0F);
    EXPECT_FALSE(stopping.met(0.5));
    EXPECT_TRUE(stopping.met(0.51));
    pixel.add(1.0F);
    EXPECT_FALSE(stopping.met(0.66));
    EXPECT_TRUE(stopping.met(0.67));
    // A film with samples of an earlier render does one pass at least.
    Stopping again(StopTime{1e-6}, pixel.film);
    EXPECT_FALSE(again.met(0.0));
}

TEST(Stopping, NoiseIsNotBelievedEarly)
{
    OnePixel pixel;
    Stopping stopping(StopNoise{0.1}, pixel.film);
    pixel.add(15, 1.0F);
    EXPECT_EQ(pixel.film.noise(), 0.0);
    EXPECT_FALSE(stopping.met(1.0));
    pixel.add(1.0F);
    EXPECT_TRUE(stopping.met(1.0));
    EXPECT_FALSE(stopping.black());
    pixel.add(3.0F);
    EXPECT_FALSE(Stopping(StopNoise{0.01}, pixel.film).met(1.0));
}

TEST(Stopping, NoiseIsLookedAtEverySixteenth)
{
    OnePixel pixel;
    Stopping stopping(StopNoise{0.1}, pixel.film);
    pixel.add(128, 0.0F); // of which nothing can be said yet
    EXPECT_FALSE(stopping.met(1.0));
    pixel.film.clear();
    pixel.add(135, 1.0F);
    EXPECT_FALSE(stopping.met(1.0));
    pixel.add(1.0F);
    EXPECT_TRUE(stopping.met(1.0));
}

TEST(Stopping, BlackImagesEnd)
{
    OnePixel pixel;
    Stopping stopping(StopNoise{0.1}, pixel.film);
    pixel.add(255, 0.0F);
    EXPECT_FALSE(stopping.met(1.0));
    pixel.add(0.0F);
    EXPECT_TRUE(stopping.met(1.0));
    EXPECT_TRUE(stopping.black());
    EXPECT_FALSE(Stopping(StopSamples{256}, pixel.film).black());
}

} // namespace
} // namespace lumisweep

#include "lumisweep/light/latlong.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "environments.h"
#include "lumisweep/base/error.h"
#include "lumisweep/image/hdr.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

using test::flux;

Image black(int width, int height)
{
    Image image;
    image.width = width;
    image.height = height;
    for (const char* name : {"R", "G", "B"})
        image.channels.push_back({name, std::vector<float>(static_cast<std::size_t>(width * height))});
    return image;
}

void set(Image& image, int column, int row, const Vec3d& rgb)
{
    for (int c = 0; c < 3; ++c)
        image.channels[static_cast<std::size_t>(c)].pixels[static_cast<std::size_t>(row * image.width + column)] =
            static_cast<float>(component(rgb, c));
}

double pixel_sr(const Image& image, int row)
{
    return 2.0 * pi / image.width * (std::cos(pi * row / image.height) - std::cos(pi * (row + 1) / image.height));
}

/// The direction of a point of the image (in pixels from its upper left corner), by the documented convention.
Vec3d direction(const Image& image, double column, double row, double rotation_deg)
{
    const double phi = 2.0 * pi * (0.5 - column / image.width) + rotation_deg * pi / 180.0;
    const double theta = pi * row / image.height;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// The pixel that a direction falls on; the inverse of the above.
Vec3d pixel_value(const Image& image, const Vec3d& w, double rotation_deg)
{
    const double phi = std::atan2(w.y, w.x) - rotation_deg * pi / 180.0;
    double u = 0.5 - phi / (2.0 * pi);
    u -= std::floor(u);
    const double v = std::atan2(std::hypot(w.x, w.y), w.z) / pi;
    const int column = std::min(static_cast<int>(u * image.width), image.width - 1);
    const int row = std::min(static_cast<int>(v * image.height), image.height - 1);
    const auto i = static_cast<std::size_t>(row * image.width + column);
    return {image.channels[0].pixels[i], image.channels[1].pixels[i], image.channels[2].pixels[i]};
}

constexpr double rotations[] = {0.0, 90.0, 33.75, 17.123, -141.7, 1000.5};

TEST(LatLong, SunsKeepTheirFluxEverywhere)
{
    // Sizes of every residue modulo 4, odd heights with the equator inside of a row; poles, seam, quadrant edges,
    // random.
    std::mt19937 random(3);
    int places = 0;
    for (const auto& [width, height] : {std::pair{64, 32}, {61, 31}, {62, 30}, {63, 33}}) {
        std::vector<std::pair<int, int>> sites;
        for (const int row : {0, 1, height / 2 - 1, height / 2, height - 2, height - 1})
            for (const int column : {0, width / 4 - 1, width / 4, width / 2, width - 1})
                sites.emplace_back(column, row);
        for (int i = 0; i < 10; ++i)
            sites.emplace_back(random() % static_cast<unsigned>(width), random() % static_cast<unsigned>(height));
        for (const auto& [column, row] : sites) {
            const double rotation = rotations[places++ % 6];
            Image image = black(width, height);
            set(image, column, row, {30000.0, 20000.0, 1.0});
            set(image, (column + 1) % width, row, {1.0, 20000.0, 5.0});
            const Vec3d found = flux(environment_from_latlong(image, 2.0, rotation));
            const Vec3d expected = Vec3d{30001.0, 40000.0, 6.0} * (2.0 * pixel_sr(image, row));
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(component(found, c), component(expected, c), 2e-7 * component(expected, c))
                    << width << " x " << height << ", pixel " << column << ", " << row << ", rotated by " << rotation;
        }
    }
    EXPECT_GE(places, 150);
}

TEST(LatLong, OnePixelOfALargeMapKeepsItsFlux)
{
    // A pixel smaller than a texel: beside the pole its solid angle is a thousandth of a texel's.
    for (const int row : {0, 1, 200, 511}) {
        Image image = black(1024, 512);
        set(image, 777, row, {1e6, 1e4, 1.0});
        const double expected = 1e6 * pixel_sr(image, row);
        EXPECT_NEAR(flux(environment_from_latlong(image, 1.0, 12.3)).x, expected, 3e-7 * expected) << row;
    }
}

TEST(LatLong, ConstantsStayConstant)
{
    for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {64, 32}, {100, 77}, {1024, 512}, {1000, 333}}) {
        Image image = black(width, height);
        for (Channel& channel : image.channels)
            std::fill(channel.pixels.begin(), channel.pixels.end(), 3.0F);
        for (const double rotation : {0.0, 17.123}) {
            const Environment environment = environment_from_latlong(image, 0.5, rotation);
            const std::size_t n = static_cast<std::size_t>(environment.resolution());
            float low = 9.0F, high = 0.0F;
            for (std::size_t i = 0; i < 3 * n * n; ++i) {
                low = std::min(low, environment.view().radiance[i]);
                high = std::max(high, environment.view().radiance[i]);
            }
            EXPECT_NEAR(low, 1.5, 3e-7) << width << " x " << height;
            EXPECT_NEAR(high, 1.5, 3e-7) << width << " x " << height;
        }
    }
}

TEST(LatLong, BrightPixelIsWhereTheConventionSays)
{
    // The centre column looks along +X, the one a quarter to its left along +Y, row 0 is +Z.
    EXPECT_NEAR(direction(black(8, 4), 4, 2, 0).x, 1.0, 1e-12);
    EXPECT_NEAR(direction(black(8, 4), 2, 2, 0).y, 1.0, 1e-12);
    for (const double rotation : rotations) {
        for (const auto& [column, row] : {std::pair{5, 3}, {14, 9}, {20, 2}, {30, 13}}) {
            Image image = black(32, 16);
            set(image, column, row, {8.0, 4.0, 2.0});
            const Environment environment = environment_from_latlong(image, 1.0, rotation);
            const Vec3d w = direction(image, column + 0.5, row + 0.5, rotation);
            const Vec3d found = environment.radiance(w);
            EXPECT_NEAR(found.x, 8.0, 1e-5);
            EXPECT_NEAR(found.y, 4.0, 1e-5);
            EXPECT_NEAR(found.z, 2.0, 1e-5);
            const double mirrored_azimuth = -std::atan2(w.y, w.x);
            const double rho = std::hypot(w.x, w.y);
            const Vec3d mirrored{rho * std::cos(mirrored_azimuth + 0.7), rho * std::sin(mirrored_azimuth + 0.7), w.z};
            EXPECT_EQ(environment.radiance(mirrored), (Vec3d{0, 0, 0})) << rotation << ": " << column;
            EXPECT_EQ(environment.radiance({w.x, w.y, -w.z}), (Vec3d{0, 0, 0}));
            EXPECT_EQ(environment.radiance({-w.x, -w.y, w.z}), (Vec3d{0, 0, 0}));
        }
    }
    // In words: +Y light turned by 90 degrees comes from −X.
    Image image = black(8, 4);
    for (const int column : {1, 2})
        for (const int row : {1, 2})
            set(image, column, row, {1.0, 1.0, 1.0});
    EXPECT_NEAR(environment_from_latlong(image, 1.0, 0.0).radiance({0, 1, 0.01}).x, 1.0, 1e-6);
    EXPECT_NEAR(environment_from_latlong(image, 1.0, 90.0).radiance({-1, 0.01, 0}).x, 1.0, 1e-6);
}

TEST(LatLong, TexelsAreMeansOfTheImageOverThem)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0.0F, 10.0F);
    for (const auto& [width, height] : {std::pair{400, 200}, {397, 211}, {30, 15}}) {
        Image image = black(width, height);
        for (Channel& channel : image.channels)
            for (float& value : channel.pixels)
                value = uniform(random);
        for (const double rotation : {0.0, 17.123}) {
            const Environment environment = environment_from_latlong(image, 1.0, rotation);
            const int n = environment.resolution();
            for (int k = 0; k < 300; ++k) {
                // Some at the poles, the axes and the equator, the rest anywhere.
                const int special[] = {0, n / 4, n / 2 - 1, n / 2, n - 1};
                const int x = k < 25 ? special[k % 5] : static_cast<int>(random() % static_cast<unsigned>(n));
                const int y = k < 25 ? special[k / 5] : static_cast<int>(random() % static_cast<unsigned>(n));
                // At the poles a texel holds slices of a hundred pixels.
                const bool at_south = (x == 0 || x == n - 1) && (y == 0 || y == n - 1);
                const bool at_north = std::abs(x - y) <= 1 && (x == n / 2 || x == n / 2 - 1);
                const int s = at_south || at_north ? 512 : 64;
                Vec3d mean{0, 0, 0};
                for (int i = 0; i < s * s; ++i) {
                    const UV<double> uv{(x + (i % s + 0.5) / s) / n, (y + (i / s + 0.5) / s) / n};
                    mean = mean + pixel_value(image, direction_from_oct(uv), rotation) * (1.0 / s / s);
                }
                const float* rgb = environment.view().radiance + 3 * morton_encode(x, y);
                // The quadrature errs where pixel edges cross its cells: a few hundredths of the image's contrast.
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(rgb[c], component(mean, c), 0.08) << width << ": texel " << x << ", " << y;
            }
        }
    }
}

TEST(LatLong, KeepsIntegralAndFirstMomentsOfASmoothMap)
{
    // L = 1 + (0.3 x + 0.2 y − 0.5 z): ∫ L dω = 4π, ∫ L ω dω = (4π/3) (0.3, 0.2, −0.5). Pixels hold exact means.
    constexpr int width = 256, height = 128;
    for (const double rotation : {0.0, 40.0}) {
        Image image = black(width, height);
        const double a = rotation * pi / 180.0;
        const double cx = 0.3 * std::cos(a) + 0.2 * std::sin(a), cy = 0.2 * std::cos(a) - 0.3 * std::sin(a);
        for (int row = 0; row < height; ++row) {
            const double t0 = pi * row / height, t1 = pi * (row + 1) / height, sr = pixel_sr(image, row);
            const double sine_squared = 0.5 * (t1 - t0) - 0.25 * (std::sin(2 * t1) - std::sin(2 * t0));
            const double z = 0.5 * (std::cos(t0) + std::cos(t1));
            for (int column = 0; column < width; ++column) {
                const double p1 = 2 * pi * (0.5 - static_cast<double>(column) / width), p0 = p1 - 2 * pi / width;
                const double x = (std::sin(p1) - std::sin(p0)) * sine_squared / sr;
                const double y = (std::cos(p0) - std::cos(p1)) * sine_squared / sr;
                const double value = 1.0 + cx * x + cy * y - 0.5 * z;
                set(image, column, row, {value, value, value});
            }
        }
        const Environment environment = environment_from_latlong(image, 1.0, rotation);
        EXPECT_NEAR(flux(environment).x, 4 * pi, 4 * pi * 1e-7);
        Vec3d moment{0, 0, 0};
        const int n = environment.resolution();
        for (int i = 0; i < n * n; ++i) {
            const TexelXY<int> t = morton_decode(i);
            moment = moment + direction_from_oct(UV<double>{(t.x + 0.5) / n, (t.y + 0.5) / n}) *
                                  (environment.view().radiance[3 * i] * 4 * pi / n / n);
        }
        // Held constant over pixels and texels of about 1.4 degrees: second order in their size.
        EXPECT_NEAR(moment.x, 4 * pi / 3 * 0.3, 4e-4);
        EXPECT_NEAR(moment.y, 4 * pi / 3 * 0.2, 4e-4);
        EXPECT_NEAR(moment.z, 4 * pi / 3 * -0.5, 4e-4);
    }
}

TEST(LatLong, PhotographedSkiesKeepTheirFlux)
{
    const std::filesystem::path environments = std::filesystem::path(LUMISWEEP_FETCHED_DATA) / "environments";
    if (!std::filesystem::exists(environments))
        GTEST_SKIP() << "no fetched data in " << environments;
    for (const auto& entry : std::filesystem::directory_iterator(environments)) {
        if (entry.path().extension() != ".exr")
            continue;
        const Image image = load_latlong(entry.path());
        const Vec3d found = flux(environment_from_latlong(image, 1.0, 12.3));
        for (int c = 0; c < 3; ++c) {
            double expected = 0.0;
            const std::vector<float>& pixels = image.find(std::string(1, "RGB"[c]))->pixels;
            for (std::size_t i = 0; i < pixels.size(); ++i)
                expected += std::max(pixels[i], 0.0F) * pixel_sr(image, static_cast<int>(i) / image.width);
            EXPECT_NEAR(component(found, c), expected, 1e-7 * expected) << entry.path();
        }
    }
}

TEST(LatLong, IsTheSameForAnyNumberOfThreads)
{
    std::mt19937 random(9);
    Image image = black(202, 101);
    for (Channel& channel : image.channels)
        for (float& value : channel.pixels)
            value = static_cast<float>(random() % 1000);
    tbb::task_arena one(1), seven(7);
    const Environment a = one.execute([&] { return environment_from_latlong(image, 1.0, 5.0); });
    const Environment b = seven.execute([&] { return environment_from_latlong(image, 1.0, 5.0); });
    ASSERT_EQ(a.resolution(), b.resolution());
    const std::size_t bytes = 12 * static_cast<std::size_t>(a.resolution()) * static_cast<std::size_t>(a.resolution());
    EXPECT_EQ(std::memcmp(a.view().radiance, b.view().radiance, bytes), 0);
}

TEST(LatLong, ClampsAndCountsWhatIsNoRadiance)
{
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Image image = black(16, 8);
    set(image, 3, 3, {-3900.0, 1.0, 1.0});
    set(image, 4, 3, {-1e-3, -1.0, infinity});
    set(image, 5, 3, {1.0, std::numeric_limits<float>::quiet_NaN(), -infinity});
    LatLongReport report;
    const Environment environment = environment_from_latlong(image, 1.0, 0.0, &report);
    EXPECT_EQ(report.negative_texels, 2U);
    EXPECT_EQ(report.non_finite_texels, 2U);
    EXPECT_EQ(report.resolution, 256);
    const Vec3d sum = flux(environment), unit{pixel_sr(image, 3), pixel_sr(image, 3), pixel_sr(image, 3)};
    EXPECT_NEAR(sum.x, unit.x, 1e-6 * unit.x);
    EXPECT_NEAR(sum.y, unit.x, 1e-6 * unit.x);
    EXPECT_NEAR(sum.z, unit.x, 1e-6 * unit.x);
}

TEST(LatLong, ChoosesTheResolution)
{
    EXPECT_EQ(octahedral_resolution(1, 1), 256);
    EXPECT_EQ(octahedral_resolution(512, 128), 256);
    EXPECT_EQ(octahedral_resolution(512, 256), 512);
    EXPECT_EQ(octahedral_resolution(1024, 512), 1024);
    EXPECT_EQ(octahedral_resolution(4096, 2048), 4096);
    EXPECT_EQ(octahedral_resolution(65536, 65536), 16384);
}

TEST(LatLong, RefusesWhatMakesNoSense)
{
    const Image image = black(8, 4);
    EXPECT_THROW(environment_from_latlong(Image{}, 1.0, 0.0), Error);
    EXPECT_THROW(environment_from_latlong(image, -1.0, 0.0), Error);
    EXPECT_THROW(environment_from_latlong(image, std::nan(""), 0.0), Error);
    EXPECT_THROW(environment_from_latlong(image, 1.0, std::numeric_limits<double>::infinity()), Error);
    Image no_blue = image;
    no_blue.channels.pop_back();
    EXPECT_THROW(environment_from_latlong(no_blue, 1.0, 0.0), Error);
    Image bright = image;
    set(bright, 2, 2, {1e30, 1e30, 1e30});
    EXPECT_THROW(environment_from_latlong(bright, 1e10, 0.0), Error);
}

} // namespace
} // namespace lumisweep

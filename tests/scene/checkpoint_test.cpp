// Checkpoints come back to the bit, or not at all.
#include "lumisweep/scene/checkpoint.h"

#include <cstring>
#include <fstream>

#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/hash.h"

namespace lumisweep {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const Fingerprint fingerprint{{"seed", "3"}, {"camera", "0123456789abcdef"}};

Film some_film()
{
    Film film(3, 2);
    for (std::size_t i = 0; i < film.arrays().color_sum.size(); ++i) {
        film.arrays().color_sum[i] = 0.1 * static_cast<double>(i);
        film.arrays().color_sum_squares[i] = 0.01 * static_cast<double>(i * i);
        film.arrays().block_begin[i] = 0.07 * static_cast<double>(i);
        film.arrays().block_sum_squares[i] = 0.03 * static_cast<double>(i);
    }
    for (std::size_t i = 0; i < film.arrays().features.size(); ++i)
        film.arrays().features[i] = 1.0F / static_cast<float>(i + 1);
    film.set_samples(11);
    return film;
}

class Checkpoint : public testing::Test {
protected:
    /// One for each process: CTest runs tests of this program side by side.
    fs::path file =
        fs::path(testing::TempDir()) / ("lumisweep_checkpoint_test-" + std::to_string(::getpid()) + ".ckpt");
    ~Checkpoint() override { fs::remove(file); }

    std::string refusal(const Fingerprint& expected = fingerprint) const
    {
        try {
            read_checkpoint(file, expected);
        } catch (const Error& error) {
            return error.what();
        }
        return "accepted";
    }
    std::string bytes() const
    {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    void put(const std::string& content) const { std::ofstream(file, std::ios::binary) << content; }
};

void expect_same(const Film& a, const Film& b)
{
    ASSERT_EQ(a.width(), b.width());
    ASSERT_EQ(a.height(), b.height());
    EXPECT_EQ(a.samples(), b.samples());
    EXPECT_EQ(std::memcmp(a.arrays().color_sum.data(), b.arrays().color_sum.data(), a.arrays().color_sum.bytes()), 0);
    EXPECT_EQ(std::memcmp(a.arrays().color_sum_squares.data(), b.arrays().color_sum_squares.data(),
                          a.arrays().color_sum_squares.bytes()),
              0);
    EXPECT_EQ(std::memcmp(a.arrays().block_sum_squares.data(), b.arrays().block_sum_squares.data(),
                          a.arrays().block_sum_squares.bytes()),
              0);
    EXPECT_EQ(std::memcmp(a.arrays().block_begin.data(), b.arrays().block_begin.data(), a.arrays().block_begin.bytes()),
              0);
    EXPECT_EQ(std::memcmp(a.arrays().features.data(), b.arrays().features.data(), a.arrays().features.bytes()), 0);
}

TEST_F(Checkpoint, ComesBackToTheBit)
{
    const Film film = some_film();
    write_checkpoint(file, film, fingerprint);
    expect_same(read_checkpoint(file, fingerprint), film);
}

TEST_F(Checkpoint, OfAnotherRenderSaysWhatDiffers)
{
    write_checkpoint(file, some_film(), fingerprint);
    EXPECT_THAT(refusal({{"seed", "4"}, {"camera", "0123456789abcdef"}}), HasSubstr("another seed (3, not 4) "));
    EXPECT_THAT(refusal({{"seed", "3"}, {"camera", "ffffffffffffffff"}}), HasSubstr("another camera "));
}

TEST_F(Checkpoint, NoByteMayChangeAndNoneMayLack)
{
    write_checkpoint(file, some_film(), fingerprint);
    const std::string whole = bytes();
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        put(damaged);
        EXPECT_NE(refusal(), "accepted") << "byte " << at;
    }
    for (std::size_t size = 0; size < whole.size(); size += 13) {
        put(whole.substr(0, size));
        EXPECT_NE(refusal(), "accepted") << size << " bytes";
    }
    put(whole + "x");
    EXPECT_NE(refusal(), "accepted");
    fs::remove(file);
    EXPECT_THAT(refusal(), HasSubstr("no such checkpoint"));
}

TEST_F(Checkpoint, WriterLeavesTheNewestFilm)
{
    Film film = some_film();
    {
        CheckpointWriter writer(file, fingerprint);
        for (int pass = 0; pass < 20; ++pass) {
            film.set_samples(film.samples() + 1);
            film.arrays().color_sum[0] += 1.0;
            writer.offer(film);
        }
        writer.finish(film);
    }
    expect_same(read_checkpoint(file, fingerprint), film);
}

TEST_F(Checkpoint, WriterReportsAFolderThatIsGone)
{
    CheckpointWriter writer("/nowhere/at/all.ckpt", fingerprint);
    EXPECT_THROW(writer.finish(some_film()), Error);
}

TEST(Hash, DependsOnEveryByteOnOrderAndOnLength)
{
    std::vector<unsigned char> data(100);
    const std::uint64_t whole = hash_bytes(data.data(), data.size());
    for (std::size_t i = 0; i < data.size(); ++i) {
        data[i] = 1;
        EXPECT_NE(hash_bytes(data.data(), data.size()), whole);
        data[i] = 0;
    }
    EXPECT_NE(hash_bytes(data.data(), 99), whole);
    EXPECT_NE(hash_bytes("ab", 2), hash_bytes("ba", 2));
}

TEST(FingerprintOf, TellsEveryInputApart)
{
    SessionInput input;
    input.volume = std::make_shared<ScalarGrid>(VoxelType::u8, Vec3i{4, 4, 4}, Affine3d{});
    input.transfer_function = TransferFunction({{0, 1, {1, 1, 1}}});
    input.environment = std::make_shared<Environment>();
    const Fingerprint base = fingerprint_of(input, "avx2", "1");
    EXPECT_EQ(difference(fingerprint_of(input, "avx2", "1"), base), "");
    EXPECT_EQ(difference(fingerprint_of(input, "avx2", "2"), base), "program version (2, not 1)");
    EXPECT_EQ(difference(fingerprint_of(input, "baseline", "1"), base), "instruction set (baseline, not avx2)");
    const auto changed = [&](auto change) {
        SessionInput other = input;
        change(other);
        return difference(fingerprint_of(other, "avx2", "1"), base);
    };
    EXPECT_EQ(changed([](SessionInput& i) { i.camera.lens_radius = 1.0; }), "camera");
    EXPECT_EQ(changed([](SessionInput& i) { i.image.width = 3; }), "image size (3 x 512, not 512 x 512)");
    EXPECT_EQ(changed([](SessionInput& i) { i.image.show_environment = false; }), "show_environment (false, not true)");
    EXPECT_EQ(changed([](SessionInput& i) { i.render.seed = 5; }), "seed (5, not 0)");
    EXPECT_EQ(changed([](SessionInput& i) { i.render.strategy = Strategy::uniform; }),
              "random_numbers (independent, not stratified), shadow_rays (1, not 3), strategy (uniform, not auto)");
    EXPECT_EQ(changed([](SessionInput& i) { i.render.shadow_rays = 5; }), "shadow_rays (5, not 3)");
    EXPECT_EQ(changed([](SessionInput& i) { i.render.random_numbers = RandomNumbers::independent; }),
              "random_numbers (independent, not stratified)");
    // What automatic stands for may as well be written out.
    EXPECT_EQ(changed([](SessionInput& i) { i.render.shadow_rays = automatic_shadow_rays; }), "");
    EXPECT_EQ(changed([](SessionInput& i) { i.render.random_numbers = RandomNumbers::stratified; }), "");
    EXPECT_EQ(changed([](SessionInput& i) { i.visibility.cell = 2; }), "visibility settings");
    EXPECT_EQ(changed([](SessionInput& i) {
                  i.transfer_function = TransferFunction({{0, 2, {1, 1, 1}}});
              }),
              "transfer function");
    EXPECT_EQ(changed([](SessionInput& i) {
                  i.environment = std::make_shared<Environment>(Environment::constant({2, 1, 1}));
              }),
              "environment");
    EXPECT_EQ(changed([](SessionInput& i) {
                  auto volume = std::make_shared<ScalarGrid>(VoxelType::u8, Vec3i{4, 4, 4}, Affine3d{});
                  volume->voxels<std::uint8_t>()[63] = 1;
                  i.volume = volume;
              }),
              "volume");
}

} // namespace
} // namespace lumisweep

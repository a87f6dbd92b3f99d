// The scene file: what it accepts, and one clear line for everything that it refuses.
#include "lumisweep/scene/scene_file.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* full_scene = R"({
  // everything that a scene can say
  "version": 1,
  "volume": {"file": "head.nrrd", "frame": 2},
  "transfer_function": {"points": [
      {"value": 150, "extinction": 0.0, "albedo": [0.9, 0.7, 0.6]},
      {"value": 400, "extinction": 4.0, "albedo": [0.95, 0.9, 0.85]}], "extinction_scale": 2},
  "environment": {"file": "sunset.exr", "scale": 1.5, "rotation_deg": 30},
  "camera": {"position": [0, -500, 100], "target": [0, 0, 0], "up": [0, 0, 1], "vertical_fov_deg": 35,
             "lens_radius": 0.5, "focus_distance": 500},
  "image": {"width": 320, "height": 200, "show_environment": false},
  "render": {"strategy": "combined", "samples": 16, "seed": 18446744073709551615,
             "random_numbers": "stratified", "shadow_rays": 12},
  "visibility": {"directions": 16, "cell": 8, "rays": 256, "filter": "full-angle", "oversampling": 4, "epsilon": 0.02} /* end */
})";

SceneDescription parsed(const std::string& text, const std::vector<SceneOverride>& overrides = {})
{
    return parse_scene(text, "scene.json", "/data", overrides);
}

std::string refusal(const std::string& text, const std::vector<SceneOverride>& overrides = {})
{
    try {
        parsed(text, overrides);
    } catch (const Error& error) {
        return error.what();
    }
    return "accepted";
}

TEST(SceneFile, ReadsEveryEntry)
{
    const SceneDescription scene = parsed(full_scene);
    ASSERT_TRUE(scene.volume);
    EXPECT_EQ(scene.volume->files.at(0), "/data/head.nrrd");
    EXPECT_EQ(scene.volume->frame, 2);
    ASSERT_TRUE(scene.transfer_function);
    EXPECT_EQ(scene.transfer_function->points.at(1).value, 400.0);
    EXPECT_EQ(scene.transfer_function->points.at(1).albedo, (Vec3d{0.95, 0.9, 0.85}));
    EXPECT_EQ(scene.transfer_function->extinction_scale, 2.0);
    EXPECT_EQ(std::get<std::filesystem::path>(scene.environment.light), "/data/sunset.exr");
    EXPECT_EQ(scene.environment.scale, 1.5);
    EXPECT_EQ(scene.environment.rotation_deg, 30.0);
    EXPECT_EQ(scene.camera.position, (Vec3d{0, -500, 100}));
    EXPECT_EQ(scene.camera.lens_radius, 0.5);
    EXPECT_EQ(scene.camera.focus_distance, 500.0);
    EXPECT_EQ(scene.image.height, 200);
    EXPECT_FALSE(scene.image.show_environment);
    EXPECT_EQ(scene.render.strategy, Strategy::combined);
    EXPECT_EQ(scene.render.seed, 18446744073709551615U);
    EXPECT_EQ(scene.render.random_numbers, RandomNumbers::stratified);
    EXPECT_EQ(scene.render.shadow_rays, 12);
    EXPECT_EQ(std::get<StopSamples>(scene.stop).samples, 16);
    EXPECT_EQ(scene.visibility.rays, 256);
    EXPECT_EQ(scene.visibility.filter, SweepFilter::full_angle);
}

TEST(SceneFile, StrategyNamesAreTheLibrarys)
{
    for (const Strategy strategy : {Strategy::uniform, Strategy::environment, Strategy::visibility, Strategy::combined,
                                    Strategy::two_step, Strategy::automatic})
        EXPECT_EQ(parsed(fmt::format(R"({{"render": {{"strategy": "{}"}}}})", name_of(strategy))).render.strategy,
                  strategy);
}

TEST(SceneFile, RandomNumbersAndShadowRays)
{
    const auto numbers = [](const char* name) {
        return parsed(fmt::format(R"({{"render": {{"random_numbers": "{}"}}}})", name)).render.random_numbers;
    };
    EXPECT_EQ(numbers("auto"), RandomNumbers::automatic);
    EXPECT_EQ(numbers("independent"), RandomNumbers::independent);
    EXPECT_EQ(numbers("stratified"), RandomNumbers::stratified);
    const auto rays = [](const char* value) {
        return parsed(fmt::format(R"({{"render": {{"shadow_rays": {}}}}})", value)).render.shadow_rays;
    };
    EXPECT_EQ(rays("\"auto\""), 0);
    for (int n = 1; n <= 64; ++n)
        EXPECT_EQ(rays(std::to_string(n).c_str()), n);
    // Overrides take back what the file says.
    const RenderSettings render =
        parsed(full_scene, {{"render.shadow_rays", "auto"}, {"render.random_numbers", "auto"}}).render;
    EXPECT_EQ(render.shadow_rays, 0);
    EXPECT_EQ(render.random_numbers, RandomNumbers::automatic);
}

TEST(SceneFile, WritesRandomNumbersAndShadowRays)
{
    EXPECT_THAT(scene_to_json(parsed("{}")), HasSubstr("\"strategy\": \"auto\""));
    EXPECT_THAT(scene_to_json(parsed("{}")), HasSubstr("\"random_numbers\": \"auto\""));
    EXPECT_THAT(scene_to_json(parsed("{}")), HasSubstr("\"shadow_rays\": \"auto\""));
    EXPECT_THAT(scene_to_json(parsed(full_scene)), HasSubstr("\"random_numbers\": \"stratified\""));
    EXPECT_THAT(scene_to_json(parsed(full_scene)), HasSubstr("\"shadow_rays\": 12"));
    const RenderSettings again = parsed(scene_to_json(parsed(full_scene))).render;
    EXPECT_EQ(again.random_numbers, RandomNumbers::stratified);
    EXPECT_EQ(again.shadow_rays, 12);
}

TEST(SceneFile, DefaultsAreTheContracts)
{
    const SceneDescription scene = parsed("{}");
    EXPECT_FALSE(scene.volume);
    EXPECT_FALSE(scene.transfer_function);
    EXPECT_TRUE(std::holds_alternative<SkySettings>(scene.environment.light));
    EXPECT_FALSE(scene.camera.position);
    EXPECT_EQ(scene.image.width, 512);
    EXPECT_EQ(scene.render.strategy, Strategy::automatic);
    EXPECT_EQ(scene.render.random_numbers, RandomNumbers::automatic);
    EXPECT_EQ(scene.render.shadow_rays, 0);
    EXPECT_EQ(std::get<StopSamples>(scene.stop).samples, 64);
    EXPECT_EQ(scene.visibility.directions, 8);
    EXPECT_EQ(scene.visibility.cell, 4);
    EXPECT_EQ(scene.visibility.rays, 0);
    EXPECT_EQ(scene.visibility.oversampling, 1);
    EXPECT_EQ(scene.visibility.epsilon, 0.1);
}

TEST(SceneFile, RoundTrips)
{
    for (
        const char* text :
        {full_scene, "{}",
         R"({"volume": {"files": "frames/f*.nii"}, "environment": {"radiance": [1, 2, 3]}, "render": {"time": 3}})",
         R"({"volume": {"files": ["b.mha", "a.mha"]}, "environment": {"sky": {"sun_angular_diameter_deg": 3}}})",
         R"({"transfer_function": {"preset": "ct-bone"}, "camera": {"target": [1, 2, 3]}, "render": {"noise": 0.02}})"}) {
        const std::string once = scene_to_json(parsed(text));
        EXPECT_EQ(scene_to_json(parse_scene(once, "again", "/elsewhere")), once);
    }
    EXPECT_EQ(parsed(R"({"volume": {"files": ["b.mha", "a.mha"]}})").volume->files.at(1), "/data/a.mha");
}

struct Refused {
    const char* text;
    const char* message; ///< part of it
};

// Without it the parameter prints as bytes, pointers among them, and the test's name would change with every build.
void PrintTo(const Refused& refused, std::ostream* stream) { *stream << refused.message; }

class SceneRefusal : public testing::TestWithParam<Refused> {};

TEST_P(SceneRefusal, NamesWhatIsWrong)
{
    const std::string message = refusal(GetParam().text);
    EXPECT_THAT(message, HasSubstr(GetParam().message)) << GetParam().text;
    EXPECT_THAT(message, HasSubstr("scene.json"));
    EXPECT_THAT(message, Not(HasSubstr("\n")));
}

INSTANTIATE_TEST_SUITE_P(
    Corpus, SceneRefusal,
    testing::Values(
        Refused{"", "line 1, column 1"}, Refused{"{\n  \"version\": }", "line 2, column 14"},
        Refused{"{} {}", "line 1, column 4"}, Refused{"{}garbage", "line 1, column 3"},
        Refused{"[1]", "must be an object"}, Refused{"null", "must be an object"},
        Refused{"{\"render\": {\"samples\": NaN}}", "line 1"}, Refused{R"({"render": {"noise": 1e999}})", "scene.json"},
        Refused{R"({"a": 1, "a": 2})", "\"a\" is given twice"},
        Refused{R"({"image": {"width": 1, "width": 2}})", "\"width\" is given twice"}, Refused{"/* open", "scene.json"},
        Refused{"{\"render\": {\"strategy\": \"\xff\"}}", "line 1"},
        Refused{R"({"version": 2})", "version: this program reads version 1 only, not 2"},
        Refused{R"({"version": "1"})", "version"},
        Refused{R"({"volum": {}})", "volum: unknown key (did you mean \"volume\"?)"},
        Refused{R"({"camera": {"fov": 3}})", "camera.fov: unknown key"},
        Refused{R"({"camera": {"vertical_fov": 3}})", "did you mean \"vertical_fov_deg\"?"},
        Refused{R"({"volume": {}})", "volume.file: missing"},
        Refused{R"({"volume": "head.nrrd"})", "volume: must be an object"},
        Refused{R"({"volume": {"file": 3}})", "volume.file: must be a string, not a number"},
        Refused{R"({"volume": {"file": ""}})", "volume.file: is empty"},
        Refused{R"({"volume": {"file": "a", "files": "b"}})", "volume: has file and files (give one"},
        Refused{R"({"volume": {"file": "a", "frame": -1}})", "volume.frame: -1 is out of range"},
        Refused{R"({"volume": {"file": "a", "frame": 1.5}})", "volume.frame: 1.5 is out of range"},
        Refused{R"({"transfer_function": {"points": []}})", "transfer_function.points: must be a list"},
        Refused{R"({"transfer_function": {"points": [{"value": 1}]}})",
                "transfer_function.points.0.extinction: missing"},
        Refused{R"({"transfer_function": {"points": [{"value": 1, "extinction": -1}]}})",
                "points.0.extinction: -1 is out of range"},
        Refused{R"({"transfer_function": {"points": [{"value": 2, "extinction": 1}, {"value": 1, "extinction": 1}]}})",
                "points.1.value: 1 is below the point before it, 2"},
        Refused{R"({"transfer_function": {"points": [{"value": 1, "extinction": 1, "albedo": [1, 1, 1.5]}]}})",
                "points.0.albedo.2: 1.5 is out of range"},
        Refused{R"({"transfer_function": {"points": [{"value": 1, "extinction": 1, "albedo": [1, 1]}]}})",
                "three numbers"},
        Refused{R"({"transfer_function": {"preset": "bone"}})", "transfer_function.preset: \"bone\" is not known"},
        Refused{R"({"environment": {"file": "a", "radiance": [1, 1, 1]}})", "environment: has file and radiance"},
        Refused{R"({"environment": {"radiance": [1, 1, -1]}})", "environment.radiance.2"},
        Refused{R"({"environment": {"scale": -1}})", "environment.scale"},
        Refused{R"({"environment": {"sky": {"sun_direction": [0, 0, 0]}}})", "environment.sky.sun_direction: is zero"},
        Refused{R"({"camera": {"position": [0, 0, 0], "target": [0, 0, 0]}})", "camera.position: is the target itself"},
        Refused{R"({"camera": {"position": [0, 0, 5], "target": [0, 0, 0]}})", "camera.up: is parallel"},
        Refused{R"({"camera": {"up": [0, 0, 0]}})", "camera.up: is zero"},
        Refused{R"({"camera": {"vertical_fov_deg": 180}})",
                "camera.vertical_fov_deg: 180 is out of range (give more than 0 and less than 180)"},
        Refused{R"({"camera": {"focus_distance": 0}})", "camera.focus_distance"},
        Refused{R"({"image": {"width": 0}})", "image.width: 0 is out of range (give a whole number from 1 to 16384)"},
        Refused{R"({"image": {"height": 100000}})", "image.height"},
        Refused{R"({"image": {"show_environment": 1}})", "must be true or false"},
        Refused{R"({"render": {"samples": 0}})", "render.samples"},
        Refused{R"({"render": {"samples": "many"}})", "render.samples: must be a whole number"},
        Refused{R"({"render": {"samples": 4, "time": 3}})", "render: has samples and time (give one of them)"},
        Refused{R"({"render": {"strategy": "twostep"}})",
                "render.strategy: \"twostep\" is not known (give one of uniform"},
        Refused{R"({"render": {"seed": -1}})", "render.seed"},
        Refused{R"({"render": {"seed": 18446744073709551616}})", "render.seed"},
        Refused{R"({"render": {"shadow_rays": 0}})",
                "render.shadow_rays: 0 is out of range (give a whole number from 1 to 64)"},
        Refused{R"({"render": {"shadow_rays": 65}})", "render.shadow_rays: 65 is out of range"},
        Refused{R"({"render": {"shadow_rays": -1}})", "render.shadow_rays: -1 is out of range"},
        Refused{R"({"render": {"shadow_rays": 2.5}})", "render.shadow_rays: 2.5 is out of range"},
        Refused{R"({"render": {"shadow_rays": "many"}})", "render.shadow_rays: must be \"auto\" or a whole number"},
        Refused{R"({"render": {"shadow_rays": true}})", "render.shadow_rays: must be \"auto\" or a whole number"},
        Refused{R"({"render": {"random_numbers": "sobol"}})",
                "render.random_numbers: \"sobol\" is not known (give one of auto, independent, stratified)"},
        Refused{R"({"render": {"random_numbers": 1}})", "render.random_numbers"},
        Refused{R"({"visibility": {"directions": 7}})", "visibility.directions: 7 is no power of two"},
        Refused{R"({"visibility": {"cell": 65}})", "visibility.cell"},
        Refused{R"({"visibility": {"oversampling": 2}})", "visibility.oversampling"},
        Refused{R"({"visibility": {"epsilon": 0}})", "visibility.epsilon"},
        Refused{R"({"visibility": {"rays": "some"}})", "visibility.rays"},
        Refused{R"({"visibility": {"filter": true}})", "visibility.filter"}));

TEST(SceneFile, RefusesDeepNestingAndZeroBytes)
{
    EXPECT_THAT(refusal(std::string(100000, '[')), HasSubstr("nested deeper than 32 levels"));
    EXPECT_THAT(refusal(std::string("{}\0{}", 5)), HasSubstr("line 1, column 3: a zero byte"));
}

TEST(SceneFile, RefusesHugeFilesAndDirectories)
{
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "huge_scene.json";
    std::ofstream(file) << std::string((std::size_t{16} << 20) + 1, ' ');
    EXPECT_THROW(read_scene_file(file), Error);
    std::filesystem::remove(file);
    EXPECT_THROW(read_scene_file(testing::TempDir()), Error);
    EXPECT_THROW(read_scene_file("/nowhere/scene.json"), Error);
}

TEST(SceneOverrides, ReplaceEntriesByPathAndIndex)
{
    const SceneDescription scene = parsed(full_scene, {{"transfer_function.points.0.value", "250"},
                                                       {"visibility.cell", "2"},
                                                       {"visibility.filter", "none"},
                                                       {"camera.position", "[1, 2, 3]"},
                                                       {"volume.file", "other.nrrd"}});
    EXPECT_EQ(scene.transfer_function->points.at(0).value, 250.0);
    EXPECT_EQ(scene.visibility.cell, 2);
    EXPECT_EQ(scene.visibility.filter, SweepFilter::none);
    EXPECT_EQ(scene.camera.position, (Vec3d{1, 2, 3}));
    EXPECT_EQ(scene.volume->files.at(0), "/data/other.nrrd");
    EXPECT_EQ(parsed("{}", {{"visibility.cell", "8"}}).visibility.cell, 8);
}

TEST(SceneOverrides, DropWhatTheyExclude)
{
    const SceneDescription scene =
        parsed(full_scene,
               {{"render.time", "2.5"}, {"environment.radiance", "[1,1,1]"}, {"transfer_function.preset", "smoke"}});
    EXPECT_EQ(std::get<StopTime>(scene.stop).seconds, 2.5);
    EXPECT_TRUE(std::holds_alternative<Vec3d>(scene.environment.light));
    EXPECT_EQ(scene.transfer_function->preset, "smoke");
}

TEST(SceneOverrides, AreValidatedLikeTheFile)
{
    EXPECT_THAT(refusal(full_scene, {{"visibility.cel", "8"}}),
                HasSubstr("visibility.cel: unknown key (did you mean \"cell\"?)"));
    EXPECT_THAT(refusal(full_scene, {{"render.samples", "NaN"}}), HasSubstr("render.samples"));
    EXPECT_THAT(refusal(full_scene, {{"transfer_function.points.2.value", "1"}}), HasSubstr("index 2 is beyond"));
    EXPECT_THAT(refusal(full_scene, {{"transfer_function.points.x", "1"}}), HasSubstr("must be an index"));
    EXPECT_THAT(refusal(full_scene, {{"version.x", "1"}}), HasSubstr("--set version.x"));
    EXPECT_THAT(refusal(full_scene, {{"camera..x", "1"}}), HasSubstr("an empty key"));
    EXPECT_THAT(refusal(full_scene, {{"camera.position", "[1, 2"}}), HasSubstr("--set camera.position: line 1"));
}

} // namespace
} // namespace lumisweep

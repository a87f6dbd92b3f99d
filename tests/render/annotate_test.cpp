// What images say of their render.
#include "lumisweep/render/annotate.h"

#include <gtest/gtest.h>

#include "lumisweep/base/version.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

TEST(Annotate, SaysHowItWasRendered)
{
    SessionInput input = test::homogeneous({4, 4, 4}, test::centered({4, 4, 4}, {1.0, 1.0, 1.0}), 1.0, {1.0, 1.0, 1.0});
    input.camera.position = {0.0, -20.0, 0.0};
    input.image = {4, 3, false};
    input.render.strategy = Strategy::environment;
    input.render.seed = 12;
    Session session(input, make_cpu_backend("baseline"));
    session.render_pass();
    session.render_pass();
    const Image image = annotated_image(session, 1.5);
    EXPECT_EQ(image.text.at("strategy"), "environment");
    EXPECT_EQ(image.text.at("programVersion"), std::string("lumisweep ") + version());
    EXPECT_EQ(image.text.at("isa"), "baseline");
    EXPECT_EQ(image.text.at("device"), "cpu");
    EXPECT_EQ(image.numbers.at("samplesPerPixel"), 2.0);
    EXPECT_EQ(image.numbers.at("seed"), 12.0);
    EXPECT_EQ(image.numbers.at("renderSeconds"), 1.5);
    // Row vectors: the camera's own place goes to the origin, the target along z.
    const std::vector<double>& m = image.matrices.at("worldToCamera");
    const auto z_of = [&](double y) { return y * m[4 * 1 + 2] + m[4 * 3 + 2]; };
    EXPECT_NEAR(z_of(-20.0), 0.0, 1e-12);
    EXPECT_NEAR(z_of(0.0), 20.0, 1e-12);
    ASSERT_NE(image.find("R"), nullptr);
    EXPECT_EQ(image.find("R")->pixels.size(), 12U);
}

} // namespace
} // namespace lumisweep

#include "lumisweep/render/annotate.h"

#include <array>
#include <string>
#include <vector>

#include "lumisweep/base/version.h"
#include "lumisweep/render/backend.h"

namespace lumisweep {

namespace {

/// OpenEXR's matrices act on row vectors: the transpose of ours.
std::vector<double> world_to_camera(const Camera& camera)
{
    const std::array<double, 16> m = camera.camera_from_world();
    std::vector<double> transposed(16);
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column)
            transposed[4 * column + row] = m[4 * row + column];
    return transposed;
}

} // namespace

Image annotated_image(const Session& session, double render_s)
{
    Image image = session.film().to_image();
    const SessionInput& input = session.input();
    image.text["strategy"] = name_of(input.render.strategy);
    image.text["programVersion"] = std::string("lumisweep ") + version();
    image.text["device"] = session.backend().device();
    image.text["isa"] = session.backend().isa();
    image.numbers["samplesPerPixel"] = static_cast<double>(session.film().samples());
    image.numbers["renderSeconds"] = render_s;
    image.numbers["seed"] = static_cast<double>(input.render.seed);
    image.matrices["worldToCamera"] = world_to_camera(input.camera);
    return image;
}

} // namespace lumisweep

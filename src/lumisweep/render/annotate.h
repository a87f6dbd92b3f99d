// What an image says of the render that made it, in its header.
#pragma once

#include "lumisweep/image/image.h"
#include "lumisweep/render/session.h"

namespace lumisweep {

/// The film with the attributes of docs/output.md: strategy, program version, device, instruction set, samples a pixel,
/// seed, seconds of rendering, worldToCamera. The scene's text is the caller's to add.
Image annotated_image(const Session& session, double render_s);

} // namespace lumisweep

// The public API of liblumisweep: load or wrap a volume, describe light and camera, render progressively.
// examples/embed.cpp is a whole program.
#pragma once

#include "lumisweep/backends/cpu/cpu_backend.h" // make_cpu_backend
#include "lumisweep/base/error.h"               // Error: what everything here throws
#include "lumisweep/image/exr.h"                // read_exr, write_exr
#include "lumisweep/image/hdr.h"                // load_latlong
#include "lumisweep/image/png.h"                // write_png
#include "lumisweep/image/tonemap.h"            // tone_map
#include "lumisweep/light/environment.h"        // Environment
#include "lumisweep/light/latlong.h"            // environment_from_latlong
#include "lumisweep/light/sky.h"                // SkySettings, environment_from_sky
#include "lumisweep/render/session.h"           // Session, SessionInput, Camera, ImageSettings, RenderSettings
#include "lumisweep/scene/framing.h"            // visible_box, frame_camera
#include "lumisweep/scene/load_scene.h"         // SceneDescription → SessionInput
#include "lumisweep/scene/presets.h"            // choose_preset, preset_points
#include "lumisweep/scene/scene_file.h"         // read_scene_file
#include "lumisweep/volume/io/load_volume.h"    // inspect_volume, load_volume
#include "lumisweep/volume/scalar_grid.h"       // ScalarGrid
#include "lumisweep/volume/transfer_function.h" // TransferFunction

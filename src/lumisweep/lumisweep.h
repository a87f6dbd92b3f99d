// The public API of liblumisweep: load or wrap a volume, describe light and camera, render progressively.
// examples/embed.cpp is a whole program.
#pragma once

#include "lumisweep/backends/cpu/cpu_backend.h"   // make_cpu_backend, available_isas
#include "lumisweep/backends/make_backend.h"      // make_backend: the CPU or a GPU
#include "lumisweep/base/error.h"                 // Error: what everything here throws
#include "lumisweep/base/version.h"               // version
#include "lumisweep/image/compare.h"              // compare_images
#include "lumisweep/image/exr.h"                  // read_exr, write_exr
#include "lumisweep/image/hdr.h"                  // load_latlong
#include "lumisweep/image/png.h"                  // write_png
#include "lumisweep/image/tonemap.h"              // display_settings, tone_map
#include "lumisweep/light/environment.h"          // Environment
#include "lumisweep/light/latlong.h"              // environment_from_latlong
#include "lumisweep/light/sky.h"                  // SkySettings, environment_from_sky
#include "lumisweep/render/annotate.h"            // annotated_image
#include "lumisweep/render/session.h"             // Session, SessionInput, Camera, ImageSettings, RenderSettings
#include "lumisweep/render/stopping.h"            // StopCriterion, Stopping
#include "lumisweep/sampling/direction_sampler.h" // DirectionSampler
#include "lumisweep/scene/framing.h"              // visible_box, frame_camera
#include "lumisweep/scene/load_scene.h"           // SceneDescription → SessionInput
#include "lumisweep/scene/presets.h"              // choose_preset, preset_points
#include "lumisweep/scene/scene_file.h"           // read_scene_file
#include "lumisweep/visibility/brute_force.h"     // transmittance_exact, brute_force_visibility
#include "lumisweep/visibility/extinction_grid.h" // classify
#include "lumisweep/visibility/sweep.h"           // sweep_visibility
#include "lumisweep/volume/io/array_volume.h"     // volume_from_array
#include "lumisweep/volume/io/load_volume.h"      // inspect_volume, load_volume
#include "lumisweep/volume/scalar_grid.h"         // ScalarGrid
#include "lumisweep/volume/transfer_function.h"   // TransferFunction

// What the scheduler of one instruction set offers to the CPU backend.
#pragma once

#include "lumisweep/render/pass.h"
#include "lumisweep/render/scene_view.h"

namespace lumisweep {

struct Tile {
    int x0, y0, x1, y1; ///< pixels [x0, x1) × [y0, y1)
};

/// Draws one sample of every pixel of a tile. `pass` is where its numbers come from.
using RenderTile = void (*)(const SceneView& scene, const SampleView& samples, const PassNumbers& pass,
                            const Tile& tile, PassCounts& counts);

/// One per instruction set, each in its own file with its own flags.
void render_tile_baseline(const SceneView& scene, const SampleView& samples, const PassNumbers& pass, const Tile& tile,
                          PassCounts& counts);
void render_tile_avx2(const SceneView& scene, const SampleView& samples, const PassNumbers& pass, const Tile& tile,
                      PassCounts& counts);
void render_tile_avx512(const SceneView& scene, const SampleView& samples, const PassNumbers& pass, const Tile& tile,
                        PassCounts& counts);

} // namespace lumisweep

#include "lumisweep/backends/cpu/path_stream.h"
#include "lumisweep/math/lanes.h"

namespace lumisweep {

void render_tile_baseline(const SceneView& scene, const SampleView& samples, const PassNumbers& pass, const Tile& tile,
                          PassCounts& counts)
{
    render_tile<float>(scene, samples, pass, tile, counts);
}

} // namespace lumisweep

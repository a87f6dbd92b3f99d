#include "lumisweep/backends/cpu/path_stream.h"
#include "lumisweep/math/lanes_avx2.h"

namespace lumisweep {

void render_tile_avx2(const SceneView& scene, const SampleView& samples, const PassNumbers& pass, const Tile& tile,
                      PassCounts& counts)
{
    render_tile<Avx2Float>(scene, samples, pass, tile, counts);
}

} // namespace lumisweep

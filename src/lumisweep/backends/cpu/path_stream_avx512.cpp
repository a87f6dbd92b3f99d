#include "lumisweep/backends/cpu/path_stream.h"
#include "lumisweep/math/lanes_avx512.h"

namespace lumisweep {

void render_tile_avx512(const SceneView& scene, const SampleView& samples, const PassNumbers& pass, const Tile& tile,
                        PassCounts& counts)
{
    render_tile<Avx512Float>(scene, samples, pass, tile, counts);
}

} // namespace lumisweep

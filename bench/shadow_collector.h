// Shadow rays as a render begins them, for every lane type: camera segments to their first collisions, by the
// renderer's own stages and in its schedule. Included once per instruction set.
#pragma once

#include "lumisweep/backends/cpu/path_stream.h"
#include "transmittance_view.h"

namespace lumisweep::bench {

template <class F, class Voxel>
class ShadowCollector {
public:
    LUMISWEEP_HD explicit ShadowCollector(CollectJob& job) : job_(job), grid_(grid_view<Voxel>(job.scene)) {}

    LUMISWEEP_HD void run()
    {
        const int side = 64;
        for (int y0 = 0; y0 < job_.scene.camera.height; y0 += side)
            for (int x0 = 0; x0 < job_.scene.camera.width; x0 += side)
                run_tile({x0, y0, x0 + side < job_.scene.camera.width ? x0 + side : job_.scene.camera.width,
                          y0 + side < job_.scene.camera.height ? y0 + side : job_.scene.camera.height});
    }

private:
    static constexpr int width = lane_width<F>;
    using I = int_of<F>;
    using M = mask_of<F>;

    LUMISWEEP_HD void run_tile(const Tile& tile)
    {
        int x = tile.x0, y = tile.y0;
        for (;;) {
            while (y < tile.y1 && active_.size + width <= PathQueue<F>::capacity) {
                alignas(64) std::int32_t xs[width], ys[width];
                int n = 0;
                for (int i = 0; i < width; ++i) {
                    xs[i] = y < tile.y1 ? x : tile.x0;
                    ys[i] = y < tile.y1 ? y : tile.y0;
                    n += y < tile.y1 ? 1 : 0;
                    if (++x == tile.x1) {
                        x = tile.x0;
                        ++y;
                    }
                }
                PathState<F> path;
                const M meets = stage::start(job_.scene, job_.pass, load<F>(xs), load<F>(ys), path);
                active_.append(first_lanes<F>(n) & meets, path);
            }
            if (active_.size == 0)
                return;
            step();
            scatter_all();
        }
    }

    LUMISWEEP_HD void step()
    {
        const int size = active_.size;
        active_.size = 0;
        colliding_.size = 0;
        for (int at = 0; at < size; at += width) {
            PathState<F> path;
            active_.load_group(at, path);
            M pending = first_lanes<F>(size - at), candidates = M(false);
            stage::Walk<F> walk = stage::begin_walk(job_.scene, path);
            do {
                const stage::Advanced<F> advanced = stage::advance(job_.scene, pending, path, walk);
                candidates = candidates | advanced.candidate;
                pending = pending & !(advanced.candidate | advanced.left);
            } while (count(pending) * 4 > width);
            path.cell = pack_cell<F>(job_.scene.majorants, walk.cell);
            M goes_on = pending;
            if (any(candidates)) {
                const F ratio = stage::look_up(job_.scene, grid_, candidates, path, walk);
                const stage::Judged<F> judged = stage::candidate(job_.scene, candidates, ratio, path);
                colliding_.append(judged.collided, path);
                goes_on = goes_on | (candidates & !judged.ended);
            }
            active_.append(goes_on, path);
        }
    }

    LUMISWEEP_HD void scatter_all()
    {
        for (int at = 0; at < colliding_.size; at += width) {
            PathState<F> at_collision;
            colliding_.load_group(at, at_collision);
            const M on = first_lanes<F>(colliding_.size - at);
            alignas(64) std::int32_t number[width];
            for (int i = 0; i < width; ++i)
                number[i] = job_.sink.collisions + i;
            const stage::Features<F> features = stage::collide(job_.scene, grid_, at_collision);
            for (int d = 0; d < job_.directions; ++d) {
                PathState<F> path = at_collision;
                append(stage::aim(job_.scene, job_.pass, on, I(d), features.albedo, path), path, load<F>(number));
            }
            job_.sink.collisions += count(on);
        }
    }

    LUMISWEEP_HD void append(const M& on, const PathState<F>& path, const I& collision)
    {
        ShadowSink& sink = job_.sink;
        const int n = sink.count;
        compress_store(sink.origin[0] + n, on, path.origin.x);
        compress_store(sink.origin[1] + n, on, path.origin.y);
        compress_store(sink.origin[2] + n, on, path.origin.z);
        compress_store(sink.direction[0] + n, on, path.direction.x);
        compress_store(sink.direction[1] + n, on, path.direction.y);
        compress_store(sink.direction[2] + n, on, path.direction.z);
        compress_store(sink.key[0] + n, on, path.key.k0);
        compress_store(sink.key[1] + n, on, path.key.k1);
        compress_store(sink.pixel + n, on, path.pixel);
        compress_store(sink.collision + n, on, collision);
        compress_store(sink.weight + n, on,
                       fma(path.weight.x, F(0.2126F), fma(path.weight.y, F(0.7152F), path.weight.z * F(0.0722F))));
        sink.count += count(on);
    }

    CollectJob& job_;
    GridView<Voxel> grid_;
    PathQueue<F> active_, colliding_;
};

template <class F>
LUMISWEEP_HD void collect_shadow_rays(CollectJob& job)
{
    switch (job.scene.voxel_type) {
    case VoxelType::u8: ShadowCollector<F, std::uint8_t>(job).run(); break;
    case VoxelType::u16: ShadowCollector<F, std::uint16_t>(job).run(); break;
    case VoxelType::i16: ShadowCollector<F, std::int16_t>(job).run(); break;
    case VoxelType::f32: ShadowCollector<F, float>(job).run(); break;
    }
}

} // namespace lumisweep::bench

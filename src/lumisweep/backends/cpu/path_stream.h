// The CPU schedule: a stream of about a thousand paths in structure-of-arrays form; every round takes each path to its
// next tentative collision and through it, then packs the survivors together. Camera and shadow segments share the
// rounds.
//
// Included once per instruction set with that set's lane type. No standard containers and no out-of-line helpers here:
// their code would carry the instruction set's flags and could be chosen by the linker for everyone.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cpu/tile.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/render/light_stages.h"

namespace lumisweep {

/// Groups of lanes that go through a round side by side, so that one computes while another waits for memory.
inline constexpr int bundle = 2;

/// Paths in structure-of-arrays form, packed from the front.
template <class F>
struct PathQueue {
    static constexpr int capacity = 1024;
    static constexpr int padded = capacity + bundle * lane_width<F>;
    static constexpr int float_fields = 12, int_fields = 6;
    static_assert(float_fields + int_fields == PathState<F>::field_count);

    // Zeros, because the last group of a queue may hold lanes that nothing was ever written to, and gathers follow the
    // cells and positions of all lanes.
    alignas(64) float floats[float_fields][padded] = {};
    alignas(64) std::int32_t ints[int_fields][padded] = {};
    int size = 0;

    /// Where a field of PathState is kept; fields come in the order of for_each_field.
    struct Cursor {
        PathQueue& queue;
        int at;
        int float_field = 0, int_field = 0;
        LUMISWEEP_HD float* place(const F&) { return queue.floats[float_field++] + at; }
        LUMISWEEP_HD std::int32_t* place(const int_of<F>&) { return queue.ints[int_field++] + at; }
    };

    LUMISWEEP_HD void load_group(int at, PathState<F>& path)
    {
        Cursor cursor{*this, at};
        path.for_each_field([&](auto& field) __attribute__((always_inline)) { field = load<F>(cursor.place(field)); });
    }

    /// Packs the lanes that are on behind position `size`.
    LUMISWEEP_HD void append(const mask_of<F>& on, PathState<F>& path)
    {
        Cursor cursor{*this, size};
        path.for_each_field([&](auto& field)
                                __attribute__((always_inline)) { compress_store(cursor.place(field), on, field); });
        size += count(on);
    }
};

template <class F, class Voxel>
class PathStream {
public:
    LUMISWEEP_HD PathStream(const SceneView& scene, const SampleView& samples, const PassNumbers& pass,
                            const Tile& tile, PassCounts& counts)
        : scene_(scene), grid_(grid_view<Voxel>(scene)), samples_(samples), pass_(pass), tile_(tile), counts_(counts),
          end_(1)
    {
        while (end_ < (tile.x1 - tile.x0) * (tile.x1 - tile.x0) || end_ < (tile.y1 - tile.y0) * (tile.y1 - tile.y0))
            end_ *= 4;
    }

    LUMISWEEP_HD void run()
    {
        for (;;) {
            refill();
            if (active_.size == 0)
                break;
            step();
            scatter_all();
        }
        counts_.paths +=
            static_cast<std::uint64_t>(tile_.x1 - tile_.x0) * static_cast<std::uint64_t>(tile_.y1 - tile_.y0);
    }

private:
    static constexpr int width = lane_width<F>;
    using I = int_of<F>;
    using M = mask_of<F>;

    /// Starts pixels of the tile, in Morton order, while the stream has room.
    LUMISWEEP_HD void refill()
    {
        // Every camera ray may yet become shadow_rays paths; shadow rays stay one.
        static_assert(most_shadow_rays * width <= PathQueue<F>::capacity);
        const int most = scene_.shadow_rays;
        while (next_ < end_ && active_.size + camera_rays_ * (most - 1) + width * most <= PathQueue<F>::capacity) {
            alignas(64) std::int32_t x[width], y[width];
            int n = 0;
            for (; n < width && next_ < end_; ++next_) {
                const TexelXY<int> at = morton_decode(next_);
                x[n] = tile_.x0 + at.x;
                y[n] = tile_.y0 + at.y;
                n += x[n] < tile_.x1 && y[n] < tile_.y1 ? 1 : 0;
            }
            for (int rest = n; rest < width; ++rest) {
                x[rest] = tile_.x0;
                y[rest] = tile_.y0;
            }
            const M on = first_lanes<F>(n);
            PathState<F> path;
            const M meets = stage::start(scene_, pass_, load<F>(x), load<F>(y), path);
            splat_background(on & !meets, path);
            active_.append(on & meets, path);
            camera_rays_ += count(on & meets);
        }
    }

    /// A group of lanes on its way through a round.
    struct Group {
        PathState<F> path;
        stage::Walk<F> walk;
        M pending, candidates, left;
        F ratio;
    };

    /// Calls f on every group of a bundle; written out, so that each stays in registers.
    template <class Function>
    LUMISWEEP_HD static void for_each_group(Group (&groups)[bundle], Function&& f)
    {
        static_assert(bundle == 2);
        f(groups[0], 0);
        f(groups[1], width);
    }

    /// One tentative collision for (almost) every path: a bundle goes on while more than a quarter of its lanes lack
    /// one.
    LUMISWEEP_HD void step()
    {
        const int size = active_.size;
        active_.size = 0;
        colliding_.size = 0;
        camera_rays_ = 0;
        for (int at = 0; at < size; at += bundle * width) {
            Group groups[bundle];
            for_each_group(
                groups, [&](Group & g, int offset) __attribute__((always_inline)) {
                    active_.load_group(at + offset, g.path);
                    g.pending = first_lanes<F>(size - at - offset);
                    g.candidates = g.left = M(false);
                    g.walk = stage::begin_walk(scene_, g.path);
                });
            int pending = min(size - at, bundle * width);
            do {
                counts_.advance_steps += static_cast<std::uint64_t>(pending);
                counts_.advance_lanes += static_cast<std::uint64_t>(bundle * width);
                pending = 0;
                for_each_group(
                    groups, [&](Group & g, int) __attribute__((always_inline)) {
                        const stage::Advanced<F> advanced = stage::advance(scene_, g.pending, g.path, g.walk);
                        g.candidates = g.candidates | advanced.candidate;
                        g.left = g.left | advanced.left;
                        g.pending = g.pending & !(advanced.candidate | advanced.left);
                        pending += count(g.pending);
                    });
            } while (pending * 4 > bundle * width);
            counts_.candidate_lanes += static_cast<std::uint64_t>(bundle * width);
            // All lookups before the first is used.
            for_each_group(
                groups, [&](Group & g, int) __attribute__((always_inline)) {
                    g.ratio = stage::look_up(scene_, grid_, g.candidates, g.path, g.walk);
                });
            // Writing behind the read position: size never passes `at`.
            for_each_group(
                groups, [&](Group & g, int) __attribute__((always_inline)) { end_round(g); });
        }
    }

    LUMISWEEP_HD void end_round(Group& g)
    {
        PathState<F>& path = g.path;
        path.cell = pack_cell<F>(scene_.majorants, g.walk.cell);
        const stage::Judged<F> judged = stage::candidate(scene_, g.candidates, g.ratio, path);
        colliding_.append(judged.collided, path);
        const int shadow = count(g.candidates & (path.segment == I(shadow_segment)));
        counts_.shadow_steps += static_cast<std::uint64_t>(shadow);
        counts_.camera_steps += static_cast<std::uint64_t>(count(g.candidates) - shadow);
        if (any(g.left)) {
            const M camera = g.left & (path.segment == I(camera_segment));
            splat_background(camera, path);
            splat_light(g.left & !camera, path);
        }
        const M goes_on = g.pending | (g.candidates & !judged.ended);
        active_.append(goes_on, path);
        camera_rays_ += count(goes_on & (path.segment == I(camera_segment)));
    }

    /// Shadow rays for all collisions of the round.
    LUMISWEEP_HD void scatter_all()
    {
        for (int at = 0; at < colliding_.size; at += width) {
            PathState<F> path;
            colliding_.load_group(at, path);
            const M on = first_lanes<F>(colliding_.size - at);
            const stage::Features<F> features = stage::collide(scene_, grid_, path);
            const I first =
                stage::collisions_before(path.transmittance_before(), path.collision_rest(), scene_.shadow_rays);
            const I end = stage::collisions_before(path.transmittance, path.collision_rest(), scene_.shadow_rays);
            splat_features(on, path, features,
                           to_float(end - first) * F(1.0F / static_cast<float>(scene_.shadow_rays)));
            M due = on;
            for (I n = first; any(due); n = n + I(1)) {
                PathState<F> shadow = path;
                const M lit = stage::aim(scene_, pass_, due, n, features.albedo, shadow);
                active_.append(lit, shadow);
                counts_.shadow_rays += static_cast<std::uint64_t>(count(lit));
                due = due & (n + I(1) < end);
            }
        }
    }

    LUMISWEEP_HD void splat_color(const M& on, const PathState<F>& path, const Vec3<F>& color)
    {
        alignas(64) float r[width], g[width], b[width];
        alignas(64) std::int32_t pixel[width];
        store(r, color.x), store(g, color.y), store(b, color.z), store(pixel, path.pixel);
        for (std::uint32_t left = bits(on); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            float* out = samples_.color + static_cast<std::int64_t>(pixel[lane]) * 3;
            out[0] += r[lane];
            out[1] += g[lane];
            out[2] += b[lane];
        }
    }

    LUMISWEEP_HD void splat_light(const M& on, const PathState<F>& path)
    {
        if (any(on))
            splat_color(on, path, path.weight * path.transmittance);
    }

    LUMISWEEP_HD void splat_background(const M& on, const PathState<F>& path)
    {
        if (scene_.background == BackgroundLight::hidden || !any(on))
            return;
        // What of the ray's opacity no collision stands for.
        const I collided = stage::collisions_before(path.transmittance, path.collision_rest(), scene_.shadow_rays);
        const F part = F(1.0F) - to_float(collided) * F(1.0F / static_cast<float>(scene_.shadow_rays));
        splat_color(on, path, stage::background_radiance(scene_, path) * part);
    }

    /// `part` of the camera ray's sample is what the collision stands for.
    LUMISWEEP_HD void splat_features(const M& on, const PathState<F>& path, const stage::Features<F>& features,
                                     const F& part)
    {
        alignas(64) float value[8][width];
        alignas(64) std::int32_t pixel[width];
        const Vec3<F> albedo = features.albedo * part, normal = features.normal * part;
        store(value[0], albedo.x), store(value[1], albedo.y), store(value[2], albedo.z);
        store(value[3], normal.x), store(value[4], normal.y), store(value[5], normal.z);
        store(value[6], features.depth * part), store(value[7], part);
        store(pixel, path.pixel);
        for (std::uint32_t left = bits(on); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            float* out = samples_.features + static_cast<std::int64_t>(pixel[lane]) * 8;
            for (int i = 0; i < 8; ++i)
                out[i] += value[i][lane];
        }
    }

    const SceneView& scene_;
    GridView<Voxel> grid_;
    SampleView samples_;
    PassNumbers pass_;
    Tile tile_;
    PassCounts& counts_;
    int next_ = 0, end_;  ///< Morton numbers of pixels: the next to start, and of a square around the tile
    int camera_rays_ = 0; ///< in active_
    PathQueue<F> active_, colliding_;
};

/// The tile renderer of a lane type, for any voxel type.
template <class F>
LUMISWEEP_HD void render_tile(const SceneView& scene, const SampleView& samples, const PassNumbers& pass,
                              const Tile& tile, PassCounts& counts)
{
    switch (scene.voxel_type) {
    case VoxelType::u8: PathStream<F, std::uint8_t>(scene, samples, pass, tile, counts).run(); break;
    case VoxelType::u16: PathStream<F, std::uint16_t>(scene, samples, pass, tile, counts).run(); break;
    case VoxelType::i16: PathStream<F, std::int16_t>(scene, samples, pass, tile, counts).run(); break;
    case VoxelType::f32: PathStream<F, float>(scene, samples, pass, tile, counts).run(); break;
    }
}

} // namespace lumisweep

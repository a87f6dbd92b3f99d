#include "lumisweep/backends/cuda/draw_paths.h"

#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/render/light_stages.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

constexpr int path_threads = 128;

/// What a thread keeps in shared memory, [field][thread]: a camera segment while its shadow segments are drawn, the
/// albedo that these start with, and counts.
struct Kept {
    static constexpr int fields = PathState<float>::field_count, albedo = fields, counts = fields + 3,
                         words = counts + PathCounters::kinds;

    std::uint32_t* word; ///< of this thread

    LUMISWEEP_HD void put(int field, float value) const
    {
        word[field * path_threads] = static_cast<std::uint32_t>(as_int(value));
    }
    LUMISWEEP_HD void put(int field, std::int32_t value) const
    {
        word[field * path_threads] = static_cast<std::uint32_t>(value);
    }
    LUMISWEEP_HD void get(int field, float& value) const
    {
        value = as_float(static_cast<std::int32_t>(word[field * path_threads]));
    }
    LUMISWEEP_HD void get(int field, std::int32_t& value) const
    {
        value = static_cast<std::int32_t>(word[field * path_threads]);
    }
    LUMISWEEP_HD void put(PathState<float>& path) const
    {
        int field = 0;
        path.for_each_field([&](auto& value) { put(field++, value); });
    }
    LUMISWEEP_HD void get(PathState<float>& path) const
    {
        int field = 0;
        path.for_each_field([&](auto& value) { get(field++, value); });
    }
    LUMISWEEP_HD void count(PathCounters::Kind what) const { ++word[(counts + what) * path_threads]; }
};

/// One thread's paths, one after the other. A camera segment that collides waits until the shadow segments of the
/// collision are done. Threads of a warp look up together: each goes on through cells until at most a quarter of them
/// lack a tentative collision, and new segments begin when a quarter of them have none.
template <class Voxel>
class PathThread {
public:
    LUMISWEEP_HD PathThread(const SceneView& scene, const SampleBatch& batch, std::uint32_t begin, std::uint32_t end,
                            std::uint32_t* next, const Kept& kept)
        : scene_(scene), grid_(grid_view<Voxel>(scene)), batch_(batch), begin_(begin), end_(end), next_(next),
          kept_(kept)
    {
    }

    LUMISWEEP_HD void run()
    {
        for (;;) {
            const int flying = count_in_warp(flying_);
            const int waiting = count_in_warp(!flying_ && more_);
            if (flying + waiting == 0)
                return;
            if (!flying_ && more_ && (flying == 0 || waiting * 4 >= warp_width))
                begin_segment();
            step();
        }
    }

private:
    /// The next shadow segment of the collision, else the camera segment that waits for them, else a new path.
    LUMISWEEP_HD void begin_segment()
    {
        while (!flying_ && more_) {
            if (due_ < due_end_) {
                kept_.get(path_);
                Vec3<float> albedo;
                kept_.get(Kept::albedo, albedo.x);
                kept_.get(Kept::albedo + 1, albedo.y);
                kept_.get(Kept::albedo + 2, albedo.z);
                flying_ = stage::aim<float>(scene_, batch_.pass[sample_], true, due_++, albedo, path_);
                if (flying_)
                    kept_.count(PathCounters::shadow_rays);
            } else if (camera_waits_) {
                kept_.get(path_);
                camera_waits_ = false;
                flying_ = true;
            } else {
                begin_path();
            }
        }
        if (flying_)
            walk_ = stage::begin_walk(scene_, path_);
    }

    LUMISWEEP_HD void begin_path()
    {
        const std::uint32_t taken = take_number(next_);
        if (taken >= end_ - begin_) {
            more_ = false;
            return;
        }
        const std::uint32_t number = begin_ + taken, columns = static_cast<std::uint32_t>(batch_.width + 7) / 8;
        const std::uint32_t numbers = columns * (static_cast<std::uint32_t>(batch_.height + 7) / 8) * 64;
        sample_ = static_cast<int>(number / numbers);
        const std::uint32_t of_sample = number % numbers, square = of_sample / 64;
        const TexelXY<std::int32_t> within = morton_decode(static_cast<std::int32_t>(of_sample % 64));
        const int x = static_cast<int>(square % columns) * 8 + within.x,
                  y = static_cast<int>(square / columns) * 8 + within.y;
        if (x >= batch_.width || y >= batch_.height)
            return;
        kept_.count(PathCounters::paths);
        flying_ = stage::start<float>(scene_, batch_.pass[sample_], x, y, path_);
        float *color = color_of_pixel(), *features = features_of_pixel();
        for (int i = 0; i < 3; ++i)
            color[i] = 0.0F;
        for (int i = 0; i < feature_count; ++i)
            features[i] = 0.0F;
        if (!flying_)
            splat_background();
    }

    /// To the next tentative collision, and through it.
    LUMISWEEP_HD void step()
    {
        bool pending = flying_;
        stage::Advanced<float> advanced{false, false};
        do {
            kept_.count(PathCounters::advance_lanes);
            if (pending) {
                kept_.count(PathCounters::advance_steps);
                advanced = stage::advance(scene_, true, path_, walk_);
                pending = !(advanced.candidate || advanced.left);
            }
        } while (count_in_warp(pending) * 4 > warp_width);
        if (count_in_warp(advanced.candidate) > 0)
            kept_.count(PathCounters::candidate_lanes);
        if (advanced.candidate) {
            const float ratio = stage::look_up(scene_, grid_, true, path_, walk_);
            const stage::Judged<float> judged = stage::candidate(scene_, true, ratio, path_);
            kept_.count(path_.segment == shadow_segment ? PathCounters::shadow_steps : PathCounters::camera_steps);
            if (judged.collided)
                collide(judged.ended);
            else if (judged.ended)
                flying_ = false;
        } else if (advanced.left) {
            if (path_.segment == camera_segment)
                splat_background();
            else
                splat(path_.weight * path_.transmittance);
            flying_ = false;
        }
    }

    LUMISWEEP_HD void collide(bool last)
    {
        path_.cell = pack_cell(scene_.majorants, walk_.cell);
        const stage::Features<float> features = stage::collide(scene_, grid_, path_);
        due_ = stage::collisions_before(path_.transmittance_before(), path_.collision_rest(), scene_.shadow_rays);
        due_end_ = stage::collisions_before(path_.transmittance, path_.collision_rest(), scene_.shadow_rays);
        const float part = to_float(due_end_ - due_) * (1.0F / static_cast<float>(scene_.shadow_rays));
        const Vec3<float> albedo = features.albedo * part, normal = features.normal * part;
        float* out = features_of_pixel();
        out[0] += albedo.x, out[1] += albedo.y, out[2] += albedo.z;
        out[3] += normal.x, out[4] += normal.y, out[5] += normal.z;
        out[6] += features.depth * part, out[7] += part;
        kept_.put(path_);
        kept_.put(Kept::albedo, features.albedo.x);
        kept_.put(Kept::albedo + 1, features.albedo.y);
        kept_.put(Kept::albedo + 2, features.albedo.z);
        camera_waits_ = !last;
        flying_ = false;
    }

    LUMISWEEP_HD void splat_background()
    {
        if (scene_.background == BackgroundLight::hidden)
            return;
        const int collided = stage::collisions_before(path_.transmittance, path_.collision_rest(), scene_.shadow_rays);
        const float part = 1.0F - to_float(collided) * (1.0F / static_cast<float>(scene_.shadow_rays));
        splat(stage::background_radiance(scene_, path_) * part);
    }

    LUMISWEEP_HD void splat(const Vec3<float>& color)
    {
        float* out = color_of_pixel();
        out[0] += color.x, out[1] += color.y, out[2] += color.z;
    }

    LUMISWEEP_HD std::size_t slot() const
    {
        return static_cast<std::size_t>(sample_) * static_cast<std::size_t>(batch_.width) *
                   static_cast<std::size_t>(batch_.height) +
               static_cast<std::size_t>(path_.pixel);
    }
    LUMISWEEP_HD float* color_of_pixel() const { return batch_.color + 3 * slot(); }
    LUMISWEEP_HD float* features_of_pixel() const { return batch_.features + feature_count * slot(); }

    const SceneView& scene_;
    GridView<Voxel> grid_;
    const SampleBatch& batch_;
    std::uint32_t begin_, end_;
    std::uint32_t* next_;
    Kept kept_;
    PathState<float> path_;
    stage::Walk<float> walk_;
    bool flying_ = false;       ///< path_ is a segment on its way
    bool more_ = true;          ///< there may be paths left
    bool camera_waits_ = false; ///< the kept segment goes on after its shadow segments
    int due_ = 0, due_end_ = 0; ///< collisions of the kept segment whose shadow segments have not begun
    int sample_ = 0;            ///< of the batch
};

template <class Voxel>
struct DrawPaths {
    static constexpr int threads = path_threads, blocks_a_multiprocessor = 4;

    SceneView scene;
    SampleBatch batch;
    std::uint32_t begin, end;
    PathCounters* counters;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run([&](int thread) {
            const Kept kept{block.template shared<std::uint32_t>() + thread};
            for (int i = Kept::counts; i < Kept::words; ++i)
                kept.put(i, 0);
            PathThread<Voxel>(scene, batch, begin, end, &counters->next, kept).run();
        });
        block.run_apart([&](int thread) {
            constexpr int kinds = Kept::words - Kept::counts;
            if (thread >= kinds)
                return;
            const std::uint32_t* count = block.template shared<std::uint32_t>() + (Kept::counts + thread) * threads;
            std::uint64_t sum = 0;
            for (int i = 0; i < threads; ++i)
                sum += count[(i + thread) % threads]; // each kind in a bank of its own
            atomic_add(counters->of + thread, sum);
        });
    }
};

template <class Voxel>
void draw(const SceneView& scene, const SampleBatch& batch, std::uint32_t begin, std::uint32_t end,
          PathCounters* counters, int multiprocessors, const Stream& stream)
{
    using Kernel = DrawPaths<Voxel>;
    constexpr int shared = Kept::words * path_threads * static_cast<int>(sizeof(std::uint32_t));
    const int resident = multiprocessors * resident_blocks<Kernel>(shared);
    const int needed = static_cast<int>((end - begin + path_threads - 1) / path_threads);
    launch("drawing paths", stream, {needed < resident ? needed : resident, 1, 1}, shared,
           Kernel{scene, batch, begin, end, counters});
}

struct AddToFilm {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;

    FilmSums film;
    const float *color, *features;
    std::size_t pixels;
    int count;
    int until_block_end; ///< samples of the batch that the block under way still takes, 1 … samples_a_block

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            const std::size_t i = static_cast<std::size_t>(block.index.x) * threads + static_cast<std::size_t>(thread);
            if (i < 3 * pixels)
                add_colors(i);
            if (i < feature_count * pixels) {
                float sum = film.features[i];
                for (int sample = 0; sample < count; ++sample)
                    sum += features[static_cast<std::size_t>(sample) * feature_count * pixels + i];
                film.features[i] = sum;
            }
        });
    }

private:
    LUMISWEEP_HD void add_colors(std::size_t i) const
    {
        ColorSums sums = load_sums(film, i);
        int left = until_block_end;
        for (int sample = 0; sample < count; ++sample) {
            const BlockEnd end = --left == 0 ? BlockEnd::yes : BlockEnd::no;
            sums.add(color[static_cast<std::size_t>(sample) * 3 * pixels + i], end);
            left = end == BlockEnd::yes ? static_cast<int>(samples_a_block) : left;
        }
        store_sums(film, i, sums);
    }
};

} // namespace

bool can_draw_paths() { return has_code<DrawPaths<std::uint8_t>>(); }

void draw_paths(const SceneView& scene, const SampleBatch& batch, std::uint32_t begin, std::uint32_t end,
                PathCounters* counters, int multiprocessors, const Stream& stream)
{
    switch (scene.voxel_type) {
    case VoxelType::u8: draw<std::uint8_t>(scene, batch, begin, end, counters, multiprocessors, stream); break;
    case VoxelType::u16: draw<std::uint16_t>(scene, batch, begin, end, counters, multiprocessors, stream); break;
    case VoxelType::i16: draw<std::int16_t>(scene, batch, begin, end, counters, multiprocessors, stream); break;
    case VoxelType::f32: draw<float>(scene, batch, begin, end, counters, multiprocessors, stream); break;
    }
}

void add_to_film(const FilmSums& film, const SampleBatch& batch, int count, std::int64_t first_sample,
                 const Stream& stream)
{
    const std::size_t elements = feature_count * batch.pixels();
    const int until = static_cast<int>(samples_a_block - first_sample % samples_a_block);
    launch("adding to the film", stream,
           {static_cast<int>((elements + AddToFilm::threads - 1) / AddToFilm::threads), 1, 1}, 0,
           AddToFilm{film, batch.color, batch.features, batch.pixels(), count, until});
}

} // namespace lumisweep::LUMISWEEP_CUDA

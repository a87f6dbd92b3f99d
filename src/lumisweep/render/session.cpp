#include "lumisweep/render/session.h"

#include <algorithm>
#include <limits>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/render/backend.h"
#include "lumisweep/render/camera.h"
#include "lumisweep/render/scene_view.h"
#include "lumisweep/sampling/joint_grid.h"
#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/raw_range.h"

namespace lumisweep {

namespace {

/// Kernels index these tables with 32 bits.
constexpr std::uint64_t max_entries = std::numeric_limits<std::int32_t>::max();

Linear3f linear(const Affine3d& a) { return {to_float(a.column[0]), to_float(a.column[1]), to_float(a.column[2])}; }

bool needs_joint(Strategy strategy) { return strategy != Strategy::uniform && strategy != Strategy::environment; }

std::size_t count(const Vec3i& cells)
{
    return static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) * static_cast<std::size_t>(cells.z);
}

/// Distances along a ray are kept in single precision: across the volume's diagonal a rounding is 1e-7 of it. Free
/// flights must be several times longer than that, else the density of tentative collisions is off, and finally
/// tracking stands still. At the limit they are about ten roundings long and the density is right to 0.1 %.
void validate_extinction(const ScalarGrid& volume, const TransferFunction& transfer_function)
{
    constexpr double max_depth = 1e6;
    double extinction = 0.0;
    for (const TransferPoint& p : transfer_function.points())
        extinction = std::max(extinction, p.extinction * transfer_function.extinction_scale());
    const Vec3i n = volume.size();
    const auto& column = volume.world_from_voxel().column;
    double diagonal = 0.0;
    for (const double sy : {-1.0, 1.0}) {
        for (const double sz : {-1.0, 1.0})
            diagonal = std::max(diagonal, length(column[0] * n.x + column[1] * (sy * n.y) + column[2] * (sz * n.z)));
    }
    require(
        extinction * diagonal <= max_depth,
        "transfer_function: extinction {:.3g} over a volume of {:.3g} is an optical depth of {:.3g}, above {:g} (lower "
        "transfer_function.extinction_scale; is the extinction in 1/world unit?)",
        extinction, diagonal, extinction * diagonal, max_depth);
}

void validate(const SessionInput& input)
{
    require(input.volume != nullptr && input.volume->voxel_count() > 0, "volume: is missing");
    require(input.environment != nullptr, "environment: is missing");
    input.camera.validate();
    input.image.validate();
    input.visibility.validate();
    validate_extinction(*input.volume, input.transfer_function);
    const std::size_t cells = count(VisibilityGrid::cells_of(input.volume->size(), input.visibility.cell));
    require(JointGrid::bytes_needed(cells, input.visibility.directions) / sizeof(float) <= max_entries,
            "visibility: {} cells of {} × {} directions are too many (raise visibility.cell or lower "
            "visibility.directions)",
            cells, input.visibility.directions, input.visibility.directions);
}

/// Also refuses what the memory that is left cannot hold, before any of it is taken.
void validate_with_memory(const SessionInput& input)
{
    validate(input);
    require_memory(Session::memory_needed(input.volume->size(), input.image, input.render.strategy, input.visibility),
                   "rendering this scene",
                   "a larger visibility.cell, fewer visibility.directions or a smaller image need less");
}

} // namespace

struct Session::State {
    SessionInput input;
    std::shared_ptr<Backend> backend;
    SessionStats stats;

    BoundsGrid bounds;
    RawRange raw_range;
    MajorantGrid majorants;
    VisibilityGrid visibility;
    JointGrid joint;
    std::shared_ptr<const Environment> light; // input.environment, with at least as many texels a side as directions
    Film film;
    AlignedArray<float> sample_color, sample_features;

    // What is out of date; each implies the work of prepare() below it that uses it.
    bool stale_bounds = true, stale_majorants = true, stale_visibility = true, stale_joint = true;

    Strategy strategy() const
    {
        // A black environment has no luminance to sample by; every strategy gives black, so the simplest will do.
        return input.environment->mean_luminance() > 0.0 ? input.render.strategy : Strategy::uniform;
    }

    void resize_film()
    {
        if (film.width() == input.image.width && film.height() == input.image.height) {
            film.clear();
            return;
        }
        film = Film(input.image.width, input.image.height);
        const std::size_t pixels =
            static_cast<std::size_t>(input.image.width) * static_cast<std::size_t>(input.image.height);
        sample_color = AlignedArray<float>(pixels * 3);
        sample_features = AlignedArray<float>(pixels * Film::feature_count);
        stats.film_bytes = Film::bytes_needed(input.image.width, input.image.height);
    }

    void use_environment()
    {
        light = input.environment;
        if (light->resolution() < input.visibility.directions)
            light = std::make_shared<Environment>(light->refined(input.visibility.directions));
        stats.environment_bytes = light->bytes();
    }

    SceneView view() const
    {
        const ScalarGrid& volume = *input.volume;
        SceneView view;
        view.voxel_type = volume.type();
        view.voxels = volume.data();
        view.size = volume.size();
        view.voxel_from_world = linear(volume.voxel_from_world());
        view.world_from_voxel = linear(volume.world_from_voxel());
        view.transfer_function = input.transfer_function.view(volume.slope(), volume.intercept());
        view.majorants = majorants.view();
        view.directions.strategy = strategy();
        view.directions.environment = light->view();
        view.directions.joint = joint.view();
        view.camera = camera_view(input.camera, input.image, volume);
        view.background = input.image.show_environment ? BackgroundLight::shown : BackgroundLight::hidden;
        view.seed = input.render.seed;
        return view;
    }
};

Session::Session(SessionInput input, std::shared_ptr<Backend> backend) : state_(std::make_unique<State>())
{
    validate_with_memory(input);
    state_->input = std::move(input);
    state_->backend = std::move(backend);
    state_->use_environment();
    state_->resize_film();
    state_->stats.volume_bytes = state_->input.volume->bytes();
}

Session::~Session() = default;

void Session::set_volume(std::shared_ptr<const ScalarGrid> volume)
{
    SessionInput changed = state_->input;
    changed.volume = std::move(volume);
    validate_with_memory(changed);
    state_->input = std::move(changed);
    state_->stats.volume_bytes = state_->input.volume->bytes();
    state_->stale_bounds = state_->stale_majorants = state_->stale_visibility = state_->stale_joint = true;
    state_->film.clear();
}

void Session::set_transfer_function(TransferFunction transfer_function)
{
    validate_extinction(*state_->input.volume, transfer_function);
    state_->input.transfer_function = std::move(transfer_function);
    state_->stale_majorants = state_->stale_visibility = state_->stale_joint = true;
    state_->film.clear();
}

void Session::set_environment(std::shared_ptr<const Environment> environment)
{
    require(environment != nullptr, "environment: is missing");
    state_->input.environment = std::move(environment);
    state_->use_environment();
    state_->stale_joint = true;
    state_->film.clear();
}

void Session::set_camera(const Camera& camera)
{
    camera.validate();
    state_->input.camera = camera;
    state_->film.clear();
}

void Session::set_image(const ImageSettings& image)
{
    SessionInput changed = state_->input;
    changed.image = image;
    validate_with_memory(changed);
    state_->input.image = image;
    state_->resize_film();
}

void Session::set_render(const RenderSettings& render)
{
    state_->stale_joint = state_->stale_joint || render.strategy != state_->input.render.strategy;
    state_->input.render = render;
    state_->film.clear();
}

void Session::set_visibility(const VisibilitySettings& visibility)
{
    SessionInput changed = state_->input;
    changed.visibility = visibility;
    validate_with_memory(changed);
    state_->input = std::move(changed);
    state_->use_environment();
    state_->stale_visibility = state_->stale_joint = true;
    state_->film.clear();
}

void Session::replace_visibility(VisibilityGrid grid)
{
    const Vec3i cells = VisibilityGrid::cells_of(state_->input.volume->size(), state_->input.visibility.cell);
    require(grid.cells() == cells && grid.directions_per_side() == state_->input.visibility.directions,
            "visibility grid: {} × {} × {} cells of {}² directions do not fit this session", grid.cells().x,
            grid.cells().y, grid.cells().z, grid.directions_per_side());
    state_->visibility = std::move(grid);
    state_->stale_visibility = false;
    state_->stale_joint = true;
}

void Session::prepare(const std::atomic<bool>* cancel)
{
    State& s = *state_;
    if (s.stale_bounds) {
        const Stopwatch watch(s.stats.bounds_s);
        s.bounds = BoundsGrid(*s.input.volume);
        s.raw_range = raw_range(*s.input.volume);
        s.stale_bounds = false;
    }
    if (s.stale_majorants) {
        const Stopwatch watch(s.stats.majorants_s);
        s.majorants = MajorantGrid(s.bounds, s.input.transfer_function);
        s.stats.majorant_bytes = s.majorants.bytes() + s.bounds.bytes();
        s.stale_majorants = false;
    }
    if (!needs_joint(s.strategy()))
        return;
    if (s.stale_visibility) {
        const VisibilitySettings& settings = s.input.visibility;
        const Vec3i size = s.input.volume->size();
        ExtinctionGrid extinction;
        {
            const Stopwatch watch(s.stats.classify_s);
            extinction =
                classify(*s.input.volume, s.raw_range, s.input.transfer_function, sweep_mip_level(size, settings.rays));
        }
        const Stopwatch watch(s.stats.sweep_s);
        VisibilityGrid grid(size, settings.cell, settings.directions);
        s.stats.last_sweep = sweep_visibility(grid, extinction, settings, {}, cancel);
        if (cancel != nullptr && cancel->load())
            return;
        s.visibility = std::move(grid);
        s.stale_visibility = false;
        s.stale_joint = true;
        s.stats.visibility_bytes = s.visibility.bytes();
    }
    if (s.stale_joint) {
        const Stopwatch watch(s.stats.joint_s);
        const JointFactor factor =
            s.strategy() == Strategy::visibility ? JointFactor::visibility_only : JointFactor::visibility_times_light;
        s.joint = JointGrid(); // the old one first: each may be as large as the volume
        s.joint = JointGrid(s.visibility, s.input.volume->size(), *s.light, factor, s.input.visibility.epsilon);
        s.stats.joint_bytes = s.joint.bytes();
        s.stale_joint = false;
    }
}

PassEnd Session::render_pass(const std::atomic<bool>* cancel)
{
    State& s = *state_;
    prepare(cancel);
    if (cancel != nullptr && cancel->load())
        return PassEnd::cancelled;
    const Stopwatch watch(s.stats.render_s);
    const SampleView samples{s.sample_color.data(), s.sample_features.data()};
    PassCounts counts;
    const auto discard = [&] {
        std::fill(s.sample_color.begin(), s.sample_color.end(), 0.0F);
        std::fill(s.sample_features.begin(), s.sample_features.end(), 0.0F);
    };
    PassEnd end = PassEnd::cancelled;
    try {
        end = s.backend->render_pass(s.view(), samples, s.film.samples(), cancel, counts);
    } catch (...) {
        discard();
        throw;
    }
    if (end == PassEnd::cancelled) {
        discard();
        return end;
    }
    s.film.add(samples);
    s.stats.counts += counts;
    return end;
}

const Film& Session::film() const { return state_->film; }

void Session::restore_film(Film film)
{
    require(film.width() == state_->input.image.width && film.height() == state_->input.image.height,
            "checkpoint: its image is {} × {}, not {} × {}", film.width(), film.height(), state_->input.image.width,
            state_->input.image.height);
    state_->film = std::move(film);
}

const VisibilityGrid& Session::visibility() const { return state_->visibility; }
const SessionInput& Session::input() const { return state_->input; }
const SessionStats& Session::stats() const { return state_->stats; }
const Backend& Session::backend() const { return *state_->backend; }

std::uint64_t Session::memory_needed(const Vec3i& volume_size, const ImageSettings& image, Strategy strategy,
                                     const VisibilitySettings& visibility)
{
    constexpr std::uint64_t layers = 14; // of the image that is written
    std::uint64_t bytes = Film::bytes_needed(image.width, image.height);
    bytes +=
        static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height) * layers * sizeof(float);
    bytes += count(VisibilityGrid::cells_of(volume_size, majorant_cell)) * 3 * sizeof(float);
    if (needs_joint(strategy)) {
        const std::uint64_t cells = count(VisibilityGrid::cells_of(volume_size, visibility.cell));
        const std::uint64_t directions =
            static_cast<std::uint64_t>(visibility.directions) * static_cast<std::uint64_t>(visibility.directions);
        // While sweeping: the classified level and its transposed copy, a byte a voxel each.
        const std::uint64_t sweeping = count(volume_size) * 2;
        bytes += cells * directions;
        bytes += std::max<std::uint64_t>(sweeping, JointGrid::bytes_needed(cells, visibility.directions));
    }
    return bytes;
}

} // namespace lumisweep

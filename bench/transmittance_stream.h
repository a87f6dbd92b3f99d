// Transmittance estimators for every lane type, in the schedule that the renderer has: a stream of about a thousand
// rays of which each round takes every one to its next lookup. Included once per instruction set.
#pragma once

#include "lumisweep/backends/cpu/path_stream.h"
#include "transmittance_view.h"

namespace lumisweep::bench {

/// Which fields of PathState hold what, besides origin, direction, t, cell, key and dimension:
///   all       pixel: the ray; weight.x: the roulette's threshold
///   ratio     transmittance: the product so far
///   residual  transmittance: the same; weight.y: optical depth of the control that it lacks yet
///   march     segment: −1 while the majorants are summed, then the number of the comb; transmittance: the comb's sum;
///             weight.x: optical depth of the majorant between lookups, after the sum; weight.y: optical depth of the
///             control, after the sum the closed part of T; weight.z: of the control until the roulette ends the ray,
///             then the order of the expansion
template <class F, class Voxel, Transmittance method>
class TransmittanceStream {
public:
    LUMISWEEP_HD explicit TransmittanceStream(TransmittanceJob& job) : job_(job), grid_(grid_view<Voxel>(job.scene))
    {
        for (int i = 0; i < width; ++i)
            iota_[i] = i;
    }

    LUMISWEEP_HD void run()
    {
        for (;;) {
            while (next_ < job_.rays.count && active_.size + width <= PathQueue<F>::capacity)
                start();
            if (active_.size == 0)
                return;
            step();
        }
    }

private:
    static constexpr int width = lane_width<F>;
    static constexpr bool marches = method == Transmittance::march || method == Transmittance::bounded_march;
    static constexpr bool has_control = method == Transmittance::residual || method == Transmittance::bounded_march;
    static constexpr int measuring = -1;
    static constexpr float faded_depth = 2.0F;
    using I = int_of<F>;
    using M = mask_of<F>;

    LUMISWEEP_HD void start()
    {
        const ShadowRaysView& rays = job_.rays;
        const auto three = [&](const float* const(&v)[3]) {
            return Vec3<F>{load<F>(v[0] + next_), load<F>(v[1] + next_), load<F>(v[2] + next_)};
        };
        PathState<F> path;
        path.origin = three(rays.origin);
        path.direction = three(rays.direction);
        const RandomKey<F> key = path_key<F>(load<F>(rays.key[0] + next_), job_.repetition, 0x51ed270b);
        path.key = {key.k0 ^ load<F>(rays.key[1] + next_), key.k1};
        path.pixel = load<F>(iota_) + I(next_);
        const F threshold = load<F>(job_.threshold + next_);
        const Random3<F> u = random3(path.key, I(0));
        path.t = F(0.0F);
        path.dimension = I(1);
        path.cell = cell_at(path.origin);
        path.weight = {threshold, F(0.0F), F(0.0F)};
        path.segment = I(marches ? measuring : 0);
        path.optical_depth = marches ? F(0.0F) : stage::exponential(u.b);
        path.transmittance = max(threshold, F(1.0F));
        M on = first_lanes<F>(rays.count - next_);
        if (method == Transmittance::bounded_march)
            // One number for the whole roulette: the closed part is cut to 0 where it falls below threshold · u.
            path.weight.z = F(0.0F) - log(max(threshold * (F(1.0F) - u.a), F(1e-37F)));
        else if (!marches)
            on = on & (u.a * threshold < F(1.0F));
        active_.append(on, path);
        next_ += width;
    }

    LUMISWEEP_HD void step()
    {
        const int size = active_.size;
        active_.size = 0;
        for (int at = 0; at < size; at += width) {
            PathState<F> path;
            active_.load_group(at, path);
            const M on = first_lanes<F>(size - at);
            M pending = on, candidates = M(false), left = M(false);
            do {
                job_.counts.cells += static_cast<std::uint64_t>(count(pending));
                const stage::Advanced<F> advanced = walk(pending, path);
                M alive = pending;
                if (method == Transmittance::bounded_march)
                    alive = alive & ((path.weight.y < path.weight.z) | (path.segment > I(measuring)));
                candidates = candidates | (advanced.candidate & alive);
                left = left | (advanced.left & alive);
                pending = alive & !(advanced.candidate | advanced.left);
            } while (count(pending) * 4 > width);

            M goes_on = pending;
            if (method == Transmittance::residual) {
                // Where the control is all there is, no lookup comes to play roulette.
                const M faded = pending & (path.weight.y > F(faded_depth));
                if (any(faded))
                    goes_on = goes_on & !(faded & multiply(faded, path, F(1.0F), random3(path.key, path.dimension).a));
                path.dimension = select(faded, path.dimension + I(1), path.dimension);
            }
            if (any(candidates)) {
                job_.counts.lookups += static_cast<std::uint64_t>(count(candidates));
                goes_on = goes_on | (candidates & !judge(candidates, path));
            }
            if (any(left))
                goes_on = goes_on | finish(left, path);
            active_.append(goes_on, path);
        }
    }

    struct Cell {
        I x, y, z;
    };
    LUMISWEEP_HD static I pack(const Cell& c) { return c.x | shift_left<11>(c.y) | shift_left<22>(c.z); }
    LUMISWEEP_HD static Cell unpack(const I& cell)
    {
        return {cell & I(2047), shift_right<11>(cell) & I(2047), shift_right<22>(cell)};
    }
    LUMISWEEP_HD I cell_at(const Vec3<F>& p_voxel) const
    {
        const auto axis = [](const F& p, int n) {
            constexpr float scale = 1.0F / bounds_cell;
            return min(max(to_int(fma(p, F(scale), F(0.5F * scale))), I(0)), I(n - 1));
        };
        const CellBoundsView& bounds = job_.bounds;
        return pack({axis(p_voxel.x, bounds.nx), axis(p_voxel.y, bounds.ny), axis(p_voxel.z, bounds.nz)});
    }
    LUMISWEEP_HD I cell_index(const I& cell) const
    {
        const Cell c = unpack(cell);
        return c.x + (c.y + c.z * I(job_.bounds.ny)) * I(job_.bounds.nx);
    }

    /// Through one cell, to the next lookup if it lies within.
    LUMISWEEP_HD stage::Advanced<F> walk(const M& on, PathState<F>& path)
    {
        const SceneView& scene = job_.scene;
        const Cell cell = unpack(path.cell);
        const F zero = F(0.0F);
        const auto exit_at = [&](const F& origin, const F& direction, const I& c, int n) {
            const F edge =
                fma(to_float(c + select(direction > zero, I(1), I(0))), F(static_cast<float>(bounds_cell)), F(-0.5F));
            return (min(max(edge, zero), F(static_cast<float>(n))) - origin) / direction;
        };
        const F tx = exit_at(path.origin.x, path.direction.x, cell.x, scene.size.x);
        const F ty = exit_at(path.origin.y, path.direction.y, cell.y, scene.size.y);
        const F tz = exit_at(path.origin.z, path.direction.z, cell.z, scene.size.z);
        const F t_exit = max(min(min(tx, ty), tz), path.t);

        const I index = cell_index(path.cell);
        F majorant, control = zero;
        if (has_control) {
            majorant = gather(job_.bounds.residual, index + index);
            control = gather(job_.bounds.residual + 1, index + index);
        } else {
            majorant = gather(job_.bounds.majorant, index);
        }
        const F depth = majorant * (t_exit - path.t);
        M hit = path.optical_depth < depth;
        if (marches)
            hit = hit & (path.segment > I(measuring));
        const M candidate = on & hit;
        const M moves = on & !hit;
        const F t = select(candidate, path.t + path.optical_depth / majorant, select(moves, t_exit, path.t));
        if (has_control) {
            const M counted = marches ? on & (path.segment == I(measuring)) : on;
            path.weight.y = select(counted, fma(control, t - path.t, path.weight.y), path.weight.y);
        }
        path.t = t;
        path.optical_depth = select(moves, path.optical_depth - depth, path.optical_depth);

        const M step_x = (tx <= ty) & (tx <= tz);
        const M step_y = (!step_x) & (ty <= tz);
        const M step_z = !(step_x | step_y);
        const auto next = [&](const I& c, const F& direction, const M& step) {
            return c + select(step, select(direction > zero, I(1), I(-1)), I(0));
        };
        const Cell to = {next(cell.x, path.direction.x, step_x), next(cell.y, path.direction.y, step_y),
                         next(cell.z, path.direction.z, step_z)};
        const M outside = (to.x < I(0)) | (to.y < I(0)) | (to.z < I(0)) | (to.x > I(job_.bounds.nx - 1)) |
                          (to.y > I(job_.bounds.ny - 1)) | (to.z > I(job_.bounds.nz - 1));
        path.cell = select(moves & !outside, pack(to), path.cell);
        const M left = moves & outside;
        return {candidate, left};
    }

    /// Looks extinction up; returns the lanes that end.
    LUMISWEEP_HD M judge(const M& on, PathState<F>& path)
    {
        const Vec3<F> p_voxel = {fma(path.direction.x, path.t, path.origin.x),
                                 fma(path.direction.y, path.t, path.origin.y),
                                 fma(path.direction.z, path.t, path.origin.z)};
        const F extinction = extinction_at(job_.scene.transfer_function, trilinear(grid_, p_voxel));
        const I index = cell_index(path.cell);
        F ratio;
        if (has_control)
            ratio = (extinction - gather(job_.bounds.residual + 1, index + index)) /
                    gather(job_.bounds.residual, index + index);
        else
            ratio = extinction / gather(job_.bounds.majorant, index);
        if (marches) {
            path.transmittance = select(on, path.transmittance + ratio, path.transmittance);
            path.optical_depth = select(on, path.weight.x, path.optical_depth);
            return M(false);
        }
        const Random3<F> u = random3(path.key, path.dimension);
        path.optical_depth = select(on, stage::exponential(u.b), path.optical_depth);
        path.dimension = select(on, path.dimension + I(1), path.dimension);
        if (method == Transmittance::delta)
            return u.a < ratio;
        return multiply(on, path, max(F(1.0F) - ratio, F(0.0F)), u.a);
    }

    /// Takes a factor to T, and plays roulette; returns the lanes that end.
    LUMISWEEP_HD M multiply(const M& on, PathState<F>& path, const F& factor, const F& u)
    {
        const F threshold = path.weight.x;
        F after = path.transmittance * factor;
        if (method == Transmittance::residual) {
            if (any(path.weight.y > F(0.0F)))
                after = after * exp(F(0.0F) - path.weight.y);
            path.weight.y = select(on, F(0.0F), path.weight.y);
        }
        const M low = after < threshold;
        const M dies = (low & !(u * threshold < after)) | (after <= F(0.0F));
        path.transmittance = select(on, select(low, threshold, after), path.transmittance);
        return dies;
    }

    /// Stores the estimates of rays that have left the volume; returns the lanes that shall go through it again.
    LUMISWEEP_HD M finish(const M& left, PathState<F>& path)
    {
        if constexpr (marches) {
            return next_comb(left, path);
        } else {
            F result = path.transmittance;
            if (method == Transmittance::residual)
                result = result * exp(F(0.0F) - path.weight.y);
            put(left, path.pixel, result);
            return M(false);
        }
    }

    /// A comb of equidistant lookups (in the majorant's optical depth) with a random offset estimates the optical depth
    /// τ; N + 1 of them, X_0 … X_N, estimate T = e^−X_j · Σ_k (X_j − τ)^k / k! without bias: the power becomes the
    /// elementary symmetric mean of X_j − X_i, i ≠ j, order k is looked at with probability P_k, and every X_j is the
    /// pivot once. Probabilities and the number of lookups are the paper's: P_1 = P_2 = 0.1, P_k = P_{k−1} · 2/k.
    LUMISWEEP_HD M next_comb(const M& left, PathState<F>& path)
    {
        const M measured = left & (path.segment == I(measuring));
        const F depth = F(0.0F) - path.optical_depth;
        if (method == Transmittance::bounded_march)
            path.weight.y = select(measured, max(exp(F(0.0F) - path.weight.y), path.weight.x), path.weight.y);
        else
            path.weight.y = F(1.0F);
        const M empty = measured & (depth <= F(0.0F));
        put(empty, path.pixel, path.weight.y);

        const Random3<F> u = random3(path.key, path.dimension);
        F order = F(0.0F), lookups = F(1.0F);
        if (any(measured)) {
            float probability = 0.1F;
            for (int k = 1; k <= largest_order && any(u.a < F(probability)); ++k) {
                order = order + select(u.a < F(probability), F(1.0F), F(0.0F));
                if (k > 1)
                    probability *= 2.0F / static_cast<float>(k + 1);
            }
            const F cube = (depth + F(0.015F)) * (depth + F(0.65F)) * (depth + F(60.3F));
            const F tuple = floor(exp(log(max(cube, F(1e-30F))) * F(1.0F / 3.0F)) + F(1.0F));
            lookups = max(floor(fma(tuple, F(1.0F / 1.31945F), F(0.5F))), F(1.0F));
        }
        const M combed = left & !measured;
        const F x = path.weight.x * path.transmittance;
        const M plain = combed & (path.weight.z < F(0.5F));
        put(plain, path.pixel, exp(F(0.0F) - x) * path.weight.y);
        const M again = (measured & !empty) | expand(combed & !plain, path, x);

        path.weight.x = select(measured, depth / lookups, path.weight.x);
        path.weight.z = select(measured, order, path.weight.z);
        path.segment = select(left, path.segment + I(1), path.segment);
        path.t = select(left, F(0.0F), path.t);
        path.cell = select(left, cell_at(path.origin), path.cell);
        path.transmittance = select(left, F(0.0F), path.transmittance);
        path.optical_depth = select(left, u.c * path.weight.x, path.optical_depth);
        path.dimension = select(left, path.dimension + I(1), path.dimension);
        return again;
    }

    /// Keeps the optical depths of rays of higher order, puts the estimates of those that have all of theirs, and
    /// returns the others.
    LUMISWEEP_HD M expand(const M& on, const PathState<F>& path, const F& x)
    {
        if (!any(on))
            return on;
        alignas(64) std::int32_t ray[width], comb[width];
        alignas(64) float depth[width], order[width], closed[width];
        store(ray, path.pixel), store(comb, path.segment);
        store(depth, x), store(order, path.weight.z), store(closed, path.weight.y);
        for (std::uint32_t rest = bits(on); rest != 0; rest &= rest - 1) {
            const int lane = __builtin_ctz(rest);
            float* depths = job_.combs + static_cast<std::int64_t>(ray[lane]) * (largest_order + 1);
            depths[comb[lane]] = depth[lane];
            const int n = static_cast<int>(order[lane]);
            if (comb[lane] == n)
                job_.estimates[ray[lane]] = closed[lane] * expansion(depths, n);
        }
        return on & (to_float(path.segment) < path.weight.z);
    }

    LUMISWEEP_HD static float expansion(const float* depths, int n)
    {
        double sum = 0.0;
        for (int pivot = 0; pivot <= n; ++pivot) {
            double mean[largest_order + 1] = {1.0};
            int taken = 0;
            for (int i = 0; i <= n; ++i) {
                if (i == pivot)
                    continue;
                ++taken;
                const double d = static_cast<double>(depths[pivot]) - static_cast<double>(depths[i]);
                for (int k = taken; k >= 1; --k)
                    mean[k] += (mean[k - 1] * d - mean[k]) * k / taken;
            }
            // 1 / (k! P_k) = 10 / 2^(k − 1).
            double series = 1.0, weight = 10.0;
            for (int k = 1; k <= n; ++k, weight *= 0.5)
                series += weight * mean[k];
            sum += __builtin_exp(-static_cast<double>(depths[pivot])) * series;
        }
        return static_cast<float>(sum / (n + 1));
    }

    LUMISWEEP_HD void put(const M& on, const I& rays, const F& values)
    {
        alignas(64) std::int32_t ray[width];
        alignas(64) float value[width];
        store(ray, rays), store(value, values);
        for (std::uint32_t rest = bits(on); rest != 0; rest &= rest - 1) {
            const int lane = __builtin_ctz(rest);
            job_.estimates[ray[lane]] = value[lane];
        }
    }

    TransmittanceJob& job_;
    GridView<Voxel> grid_;
    alignas(64) std::int32_t iota_[width];
    int next_ = 0;
    PathQueue<F> active_;
};

template <class F, class Voxel>
LUMISWEEP_HD void estimate_voxels(TransmittanceJob& job)
{
    switch (job.method) {
    case Transmittance::delta: TransmittanceStream<F, Voxel, Transmittance::delta>(job).run(); break;
    case Transmittance::ratio: TransmittanceStream<F, Voxel, Transmittance::ratio>(job).run(); break;
    case Transmittance::residual: TransmittanceStream<F, Voxel, Transmittance::residual>(job).run(); break;
    case Transmittance::march: TransmittanceStream<F, Voxel, Transmittance::march>(job).run(); break;
    case Transmittance::bounded_march: TransmittanceStream<F, Voxel, Transmittance::bounded_march>(job).run(); break;
    }
}

template <class F>
LUMISWEEP_HD void estimate_transmittance(TransmittanceJob& job)
{
    switch (job.scene.voxel_type) {
    case VoxelType::u8: estimate_voxels<F, std::uint8_t>(job); break;
    case VoxelType::u16: estimate_voxels<F, std::uint16_t>(job); break;
    case VoxelType::i16: estimate_voxels<F, std::int16_t>(job); break;
    case VoxelType::f32: estimate_voxels<F, float>(job); break;
    }
}

} // namespace lumisweep::bench

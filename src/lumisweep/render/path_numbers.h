// Which random numbers a path takes for what: stratified over the samples of a pixel for the few that decide most,
// independent ones for the rest.
#pragma once

#include "lumisweep/math/stratified.h"
#include "lumisweep/render/pass.h"
#include "lumisweep/render/path_state.h"
#include "lumisweep/render/scene_view.h"

namespace lumisweep::stage {

/// Uses of stratified numbers, each a sequence of its own; also the events of random3() when numbers are independent.
enum class NumberUse : int {
    pixel_and_depth, ///< a, b: place in the pixel; c: which part of the opacity along the ray the collisions are at
    lens_and_flight, ///< a, b: place on the lens; c: first free flight
    light            ///< a, b: direction; c: which of the cells around the collision it is drawn from
};

/// First event of a segment that is neither of these.
inline constexpr int first_event_dimension = 3;

/// Numbers of a use; `index` counts a pixel's drawings of that use within a block, `key` is the sample's.
template <class F>
LUMISWEEP_HD Random3<F> numbers(const SceneView& scene, const PassNumbers& pass, const PathState<F>& path,
                                const int_of<F>& index, NumberUse use)
{
    using I = int_of<F>;
    if (scene.draws == Draws::independent)
        return random3(path.key, I(static_cast<int>(use)));
    return stratified3(path_key<F>(path.pixel, pass.block.k0, pass.block.k1), index, static_cast<int>(use));
}

/// The key of a camera ray's n-th shadow ray: events of camera rays never are negative.
template <class F>
LUMISWEEP_HD RandomKey<F> shadow_key(const RandomKey<F>& camera_key, const int_of<F>& n)
{
    using I = int_of<F>;
    const RandomBits3<I> bits = random_bits3(camera_key, I(-1) - n);
    return {bits.x, bits.y};
}

} // namespace lumisweep::stage

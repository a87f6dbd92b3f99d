// Slow versions of the sweep: one direction at a time, one ray after the other through all slices.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::test {

/// What sweep_visibility must write for `direction`, to the bit: the whole numbers of sweep_geometry.h marched by plain
/// loops, looked up and filtered cell by cell.
std::vector<std::uint8_t> sweep_in_integers(const ExtinctionGrid& extinction, const VisibilitySettings& settings,
                                            int direction);

/// The same sweep in double precision with exact weights and nothing rounded, written from journal paper section 6 and
/// not from sweep_geometry.h; without filter and oversampling.
std::vector<double> sweep_in_reals(const ExtinctionGrid& extinction, const VisibilitySettings& settings, int direction);

} // namespace lumisweep::test

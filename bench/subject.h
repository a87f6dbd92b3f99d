// A volume under measurement, with everything that several benchmarks of it share, made when first asked for.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/visibility_grid.h"
#include "references.h"
#include "volumes.h"

namespace lumisweep::bench {

class Subject {
public:
    explicit Subject(Specimen specimen) : specimen_(std::move(specimen)), range_(raw_range(specimen_.volume)) {}

    const ScalarGrid& volume() const { return specimen_.volume; }
    /// As after a change of the transfer function; not kept, as its cost is itself measured.
    void classify_again(ExtinctionGrid& grid, int mip_level, ExtinctionLayouts layouts) const;
    /// With all layouts; kept.
    const ExtinctionGrid& extinction(int mip_level);
    /// 8 × 8 directions; one cell size is held at a time.
    VisibilityGrid& grid(int cell);
    const References& references(int cell, int positions);

private:
    Specimen specimen_;
    RawRange range_;
    std::map<int, ExtinctionGrid> extinction_;
    std::map<int, References> references_;
    std::optional<VisibilityGrid> grid_;
    int grid_cell_ = 0;
};

/// Seed of the positions at which errors are taken.
inline constexpr std::uint64_t reference_seed = 20;
/// Seed of the rows of cells that brute force marches.
inline constexpr std::uint64_t brute_force_seed = 21;

/// Holds one subject at a time, the one asked for last, because they are large.
class Subjects {
public:
    void add(const std::string& name, std::uint64_t memory_needed, std::function<Specimen()> make)
    {
        makers_.emplace(name, Maker{memory_needed, std::move(make)});
    }
    /// Null where less memory is available than it needs.
    Subject* get(const std::string& name);

private:
    struct Maker {
        std::uint64_t memory_needed;
        std::function<Specimen()> make;
    };
    std::map<std::string, Maker> makers_;
    std::string name_;
    std::optional<Subject> subject_;
};

} // namespace lumisweep::bench

#include "subject.h"

#include "lumisweep/base/memory.h"

namespace lumisweep::bench {

void Subject::classify_again(ExtinctionGrid& grid, int mip_level, ExtinctionLayouts layouts) const
{
    classify_into(grid, specimen_.volume, range_, specimen_.transfer_function, mip_level, layouts);
}

const ExtinctionGrid& Subject::extinction(int mip_level)
{
    const auto [found, is_new] = extinction_.try_emplace(mip_level);
    if (is_new)
        classify_again(found->second, mip_level, ExtinctionLayouts::with_transposed);
    return found->second;
}

VisibilityGrid& Subject::grid(int cell)
{
    if (!grid_ || grid_cell_ != cell) {
        grid_.reset();
        grid_.emplace(specimen_.volume.size(), cell, 8);
        grid_cell_ = cell;
    }
    return *grid_;
}

const References& Subject::references(int cell, int positions)
{
    const auto found = references_.find(cell);
    return found != references_.end()
               ? found->second
               : references_.emplace(cell, make_references(extinction(0), grid(cell), positions, reference_seed))
                     .first->second;
}

Subject* Subjects::get(const std::string& name)
{
    if (!subject_ || name_ != name) {
        subject_.reset();
        const Maker& maker = makers_.at(name);
        if (available_memory() < maker.memory_needed)
            return nullptr;
        subject_.emplace(maker.make());
        name_ = name;
    }
    return &*subject_;
}

} // namespace lumisweep::bench

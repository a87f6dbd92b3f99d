#include "lumisweep/visibility/live_visibility.h"

#include <algorithm>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

/// Directions that sweeps take at a time when they do not lack any: a group of antipodal pairs.
constexpr int group = 12;

} // namespace

int LiveVisibility::spare_slots(int directions_per_side, int threads)
{
    const int directions = directions_per_side * directions_per_side;
    return std::min(directions, std::clamp(group * threads, 2 * group, std::max(2 * group, directions / 2)));
}

std::size_t LiveVisibility::spare_bytes(std::size_t cell_count, int directions_per_side, int threads)
{
    return VisibilityGrid::direction_stride(cell_count) *
           static_cast<std::size_t>(spare_slots(directions_per_side, threads));
}

LiveVisibility::LiveVisibility(VisibilityGrid grid, int spare_slots)
    : grid_(std::move(grid)), spare_count_(spare_slots),
      slot_of_(std::make_unique<std::atomic<Slot>[]>(static_cast<std::size_t>(grid_.direction_count())))
{
    LUMISWEEP_EXPECT(spare_slots >= 1);
    for (int d = 0; d < grid_.direction_count(); ++d)
        slot_of_[static_cast<std::size_t>(d)] = grid_.direction(d);
}

void LiveVisibility::take_slots()
{
    for (int d = 0; d < grid_.direction_count(); ++d)
        grid_.directions_[static_cast<std::size_t>(d)] = slot_of_[static_cast<std::size_t>(d)].load();
}

VisibilityGrid& LiveVisibility::stage(std::span<const int> directions)
{
    LUMISWEEP_EXPECT(directions.size() <= static_cast<std::size_t>(spare_count_));
    if (spare_.empty()) {
        const std::size_t stride = VisibilityGrid::direction_stride(grid_.cell_count_);
        // All that later calls append, so that they cannot fail half way.
        free_.reserve(static_cast<std::size_t>(spare_count_));
        retired_.reserve(static_cast<std::size_t>(spare_count_));
        staged_.reserve(static_cast<std::size_t>(spare_count_));
        spare_ = AlignedArray<std::uint8_t>(stride * static_cast<std::size_t>(spare_count_), Contents::uninitialised);
        staging_.cells_ = grid_.cells_;
        staging_.cell_count_ = grid_.cell_count_;
        staging_.n_ = grid_.n_;
        for (std::size_t s = 0; s < static_cast<std::size_t>(spare_count_); ++s)
            free_.push_back(spare_.data() + s * stride);
    }
    for (const Staged& staged : staged_)
        free_.push_back(staged.slot);
    staged_.clear();
    staging_.directions_.assign(static_cast<std::size_t>(grid_.direction_count()), nullptr);
    for (reclaim(); free_.size() < directions.size(); reclaim())
        reads_.wait(retired_.back().read);
    for (const int d : directions) {
        staged_.push_back({d, free_.back()});
        staging_.directions_[static_cast<std::size_t>(d)] = free_.back();
        free_.pop_back();
    }
    return staging_;
}

void LiveVisibility::publish()
{
    const std::size_t first = retired_.size();
    for (const Staged& staged : staged_)
        retired_.push_back({slot_of_[static_cast<std::size_t>(staged.direction)].exchange(staged.slot), 0});
    // Either this sees the read that has begun, or that read sees the new slots: all these accesses are in one order.
    const int read = reads_.load();
    for (std::size_t i = first; i < retired_.size(); ++i)
        retired_[i].read = read;
    published_.fetch_add(staged_.size(), std::memory_order_release);
    staged_.clear();
}

void LiveVisibility::reclaim()
{
    const int read = reads_.load();
    std::erase_if(retired_, [&](const Retired& retired) {
        const bool held = retired.read == read && read % 2 != 0;
        if (!held)
            free_.push_back(retired.slot);
        return !held;
    });
}

} // namespace lumisweep

// A visibility grid that one thread sweeps while another reads it: double-buffered by direction.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

/// Directions lie in slots, a few more than there are directions. The writer sweeps into spare slots and publishes:
/// each direction's slot is exchanged by one atomic store, and the old one is spare once nobody reads it. The reader
/// never waits and never sees half a direction; the writer waits while a read() that may hold the slots it needs is
/// under way. One writing and one reading thread at a time; memory: the grid and the spare slots, which the first
/// stage() takes.
class LiveVisibility {
public:
    LiveVisibility(VisibilityGrid grid, int spare_slots);
    /// Enough spare slots for sweeps on so many threads to go on while what they published before is being read.
    static int spare_slots(int directions_per_side, int threads);

    int spare_slots() const { return spare_count_; }
    std::size_t bytes() const { return grid_.bytes() + spare_.bytes(); }
    static std::size_t spare_bytes(std::size_t cell_count, int directions_per_side, int threads);

    // The writer's.
    /// A grid in which these directions, at most spare_slots() and each once, may be written; no other may be touched.
    /// What was staged before and not published is forgotten.
    VisibilityGrid& stage(std::span<const int> directions);
    /// Publishes what is staged.
    void publish();

    // The reader's.
    /// Directions published so far.
    std::uint64_t published() const { return published_.load(std::memory_order_acquire); }
    /// Calls body(const VisibilityGrid&) with every direction as last published; the grid is good until body returns.
    template <class Body>
    void read(Body&& body)
    {
        const Reading reading(reads_);
        take_slots();
        body(const_cast<const VisibilityGrid&>(grid_));
    }

    /// The whole grid, to read or to write in place, while nobody else does either.
    VisibilityGrid& settled()
    {
        take_slots();
        return grid_;
    }
    const VisibilityGrid& last_read() const { return grid_; }

private:
    /// Odd while a read is under way.
    class Reading {
    public:
        explicit Reading(std::atomic<int>& reads) : reads_(reads) { reads_.fetch_add(1); }
        ~Reading()
        {
            reads_.fetch_add(1);
            reads_.notify_all();
        }
        Reading(const Reading&) = delete;
        Reading& operator=(const Reading&) = delete;

    private:
        std::atomic<int>& reads_;
    };
    using Slot = std::uint8_t*; ///< V of all cells in one direction
    struct Retired {
        Slot slot;
        int read; ///< not to be written before reads_ has left this
    };
    struct Staged {
        int direction;
        Slot slot;
    };

    void take_slots();
    void reclaim();

    VisibilityGrid grid_; ///< owns the first slots; its directions are the reader's
    int spare_count_;
    std::unique_ptr<std::atomic<Slot>[]> slot_of_; ///< [direction] published; all that the reader knows of spare slots
    std::atomic<std::uint64_t> published_{0};
    std::atomic<int> reads_{0};

    // The writer's.
    AlignedArray<std::uint8_t> spare_;
    VisibilityGrid staging_;
    std::vector<Slot> free_;
    std::vector<Retired> retired_;
    std::vector<Staged> staged_;
};

} // namespace lumisweep

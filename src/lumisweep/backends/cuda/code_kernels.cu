// The table of codes of extinction between two bounds.
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/majorant_kernels.h"
#include "lumisweep/backends/cuda/reduce.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

struct Extinctions {
    static constexpr int threads = 256, blocks_a_multiprocessor = 2;
    WholeBounds bounds;
    TransferPointsView transfer_function;
    std::uint32_t entries;
    double* extinction;
    FoundInBlocks* found;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        float* values = block.shared<float>();
        block.run([&](int thread) {
            const std::uint32_t i = static_cast<std::uint32_t>(block.index.x) * threads + static_cast<unsigned>(thread);
            values[thread] = 0.0F;
            if (i >= entries)
                return;
            extinction[i] = extinction_of_entry(bounds, transfer_function, i);
            values[thread] = static_cast<float>(extinction[i]);
        });
        reduce(block, values, [](float a, float b) { return max(a, b); });
        block.run([&](int thread) {
            // Floats that are not negative lie in the order of their bits.
            if (thread == 0)
                atomic_max(&found->largest_entry, static_cast<std::uint32_t>(as_int(values[0])));
        });
    }
};

/// Levels up to `last_level`, from shared memory: codes of half a table's worth of entries and of as many behind them.
struct LowLevels {
    static constexpr int threads = 256, blocks_a_multiprocessor = 2;
    static constexpr int last_level = 10, own = 1 << last_level, held = 2 * own;
    const double* extinction;
    std::uint32_t entries;
    int levels;
    const FoundInBlocks* found;
    std::uint8_t* maxima;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        std::uint8_t* codes = block.shared<std::uint8_t>(); // of a level, and of the next
        const std::uint32_t first = static_cast<std::uint32_t>(block.index.x) * own;
        block.run([&](int thread) {
            const float largest = found->largest();
            for (int k = thread; k < held; k += threads) {
                const std::uint32_t i = first + static_cast<std::uint32_t>(k);
                codes[k] = i < entries ? code_of_extinction(extinction[i], largest) : std::uint8_t{0};
                if (k < own && i < entries)
                    maxima[i] = codes[k];
            }
        });
        for (int level = 1; level < levels && level <= last_level; ++level) {
            const std::uint8_t* from = codes + (level - 1) % 2 * held;
            std::uint8_t* to = codes + level % 2 * held;
            const int half = 1 << (level - 1);
            block.run([&](int thread) {
                for (int k = thread; k + 2 * half <= held; k += threads) {
                    to[k] = from[k] > from[k + half] ? from[k] : from[k + half];
                    const std::uint32_t i = first + static_cast<std::uint32_t>(k);
                    if (k < own && i + 2U * static_cast<unsigned>(half) <= entries)
                        maxima[static_cast<std::uint32_t>(level) * entries + i] = to[k];
                }
            });
        }
    }
};

/// The levels above, each thread those of its entry, from neighbours on the last one of LowLevels.
struct HighLevels {
    static constexpr int threads = 256, blocks_a_multiprocessor = 2;
    std::uint32_t entries;
    int levels;
    std::uint8_t* maxima;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            const std::uint32_t i = static_cast<std::uint32_t>(block.index.x) * threads + static_cast<unsigned>(thread);
            const std::uint8_t* from = maxima + LowLevels::last_level * entries + i;
            std::uint8_t largest = 0;
            std::uint32_t reached = 0;
            for (int level = LowLevels::last_level + 1; level < levels && i + (1U << level) <= entries; ++level) {
                for (; reached < 1U << level; reached += LowLevels::own)
                    largest = from[reached] > largest ? from[reached] : largest;
                maxima[static_cast<std::uint32_t>(level) * entries + i] = largest;
            }
        });
    }
};

template <class Kernel>
Vec3i grid_for(std::uint32_t count, int of_block = Kernel::threads)
{
    return {static_cast<int>((count + static_cast<unsigned>(of_block) - 1) / static_cast<unsigned>(of_block)), 1, 1};
}

} // namespace

void find_extinctions(const WholeBounds& bounds, const TransferPointsView& transfer_function, double* extinction,
                      FoundInBlocks* found, const Stream& stream)
{
    const std::uint32_t entries = code_entries(bounds.range);
    launch("extinctions of bounds", stream, grid_for<Extinctions>(entries), Extinctions::threads * sizeof(float),
           Extinctions{bounds, transfer_function, entries, extinction, found});
}

void fill_codes(const double* extinction, std::uint32_t entries, int levels, const FoundInBlocks* found,
                std::uint8_t* maxima, const Stream& stream)
{
    launch("codes of bounds", stream, grid_for<LowLevels>(entries, LowLevels::own), 2 * LowLevels::held,
           LowLevels{extinction, entries, levels, found, maxima});
    if (levels > LowLevels::last_level + 1)
        launch("codes of wide bounds", stream, grid_for<HighLevels>(entries), 0, HighLevels{entries, levels, maxima});
}

} // namespace lumisweep::LUMISWEEP_CUDA

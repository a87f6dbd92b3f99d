#include "lumisweep/backends/cuda/device_majorants.h"

#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceMajorants::build(const DeviceBounds& bounds, const TransferPointsView& transfer_function,
                            const Stream& stream)
{
    constexpr const char* what = "the majorants";
    const WholeBounds& whole = bounds.whole();
    const std::size_t blocks = bounds.block_count();
    const std::uint32_t entries = code_entries(whole.range);
    const int levels = bits_of(entries);
    view_ = {};
    blocks_.resize(blocks, what);
    cells_.resize(blocks * rows_of_block, what);
    for (DeviceArray<std::uint8_t>& distances : distances_)
        distances.resize(blocks, what);
    extinction_.resize(entries, what);
    codes_.resize(static_cast<std::size_t>(levels) * entries, what);
    found_.resize(1, what);

    fill_on_device(found_.data(), 0, found_.bytes(), stream);
    find_extinctions(whole, transfer_function, extinction_.data(), found_.data(), stream);
    fill_codes(extinction_.data(), entries, levels, found_.data(), codes_.data(), stream);
    find_block_codes({blocks, bounds.blocks(), bounds.cells(), blocks_.data(), cells_.data()},
                     {codes_.data(), whole.range.low, entries}, whole.block_side, found_.data(), stream);
    FoundInBlocks found;
    found_.download({&found, 1}, stream);
    measure_empty_space(majorant_blocks(whole.volume_size), blocks_.data(), distances_[0].data(), distances_[1].data(),
                        stream);
    stream.wait();

    view_ = majorant_layout(whole.volume_size);
    view_.blocks = blocks_.data();
    view_.cells = reinterpret_cast<const std::uint8_t*>(cells_.data());
    view_.largest = entries > 0 ? found.largest() : 0.0F;
    if (is_thin(whole, {found.steps, found.count}, view_.largest)) {
        smallest_.resize(blocks, what);
        find_smallest(bounds.blocks(), blocks, whole.scale, transfer_function, view_.largest, smallest_.data(), stream);
        view_.smallest = smallest_.data();
    }
}

std::uint64_t DeviceMajorants::bytes() const
{
    return blocks_.bytes() + smallest_.bytes() + cells_.bytes() + distances_[0].bytes() + distances_[1].bytes() +
           extinction_.bytes() + codes_.bytes() + found_.bytes();
}

} // namespace lumisweep::LUMISWEEP_CUDA

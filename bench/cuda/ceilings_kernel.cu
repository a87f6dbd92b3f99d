#include "ceilings_kernel.h"

#include "lumisweep/backends/cuda/launch.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

struct Products {
    static constexpr int threads = ProductLoad::threads, blocks_a_multiprocessor = 1;
    int rounds;
    std::uint8_t* result;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            std::uint32_t sum[ProductLoad::chains];
            for (int i = 0; i < ProductLoad::chains; ++i)
                sum[i] = static_cast<std::uint32_t>(thread + i);
            for (int round = 0; round < rounds; ++round)
                for (int i = 0; i < ProductLoad::chains; ++i)
                    sum[i] = dot_bytes(sum[i], 0x01020304U, static_cast<std::uint32_t>(round));
            std::uint32_t all = 0;
            for (const std::uint32_t s : sum)
                all ^= s;
            if (all == 0x12345678U) // never known beforehand
                *result = 1;
        });
    }
};

} // namespace

void multiply_bytes(const ProductLoad& load, std::uint8_t* result, const Stream& stream)
{
    launch("products of bytes", stream, {load.blocks, 1, 1}, 0, Products{load.rounds, result});
}

} // namespace lumisweep::LUMISWEEP_CUDA

#include "volume_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    lumisweep::fuzz::load(data, size, ".mha");
    return 0;
}

// read_hdr on any bytes: an image or an Error, nothing else.
#include <cstddef>
#include <cstdint>
#include <span>

#include "lumisweep/base/error.h"
#include "lumisweep/image/hdr.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    try {
        lumisweep::read_hdr(std::as_bytes(std::span(data, size)), "fuzz");
    } catch (const lumisweep::Error&) {
        // The one way in which bad input may end.
    }
    return 0;
}

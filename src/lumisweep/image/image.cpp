#include "lumisweep/image/image.h"

#include <algorithm>

namespace lumisweep {

const Channel* Image::find(const std::string& name) const
{
    const auto it = std::find_if(channels.begin(), channels.end(), [&](const Channel& c) { return c.name == name; });
    return it == channels.end() ? nullptr : &*it;
}

} // namespace lumisweep

#include "lumisweep/image/exr_detail.h"

#include <algorithm>
#include <mutex>

#include <OpenEXR/IlmThreadPool.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfThreading.h>
#include <tbb/task_arena.h>

namespace lumisweep::exr_detail {

int threads()
{
    static std::mutex mutex;
    const std::scoped_lock lock(mutex);
    Imf::Header::setMaxImageSize(max_size, max_size);
    Imf::Header::setMaxTileSize(max_size, max_size);
    const int wanted = std::clamp(tbb::this_task_arena::max_concurrency(), 1, 32);
    // One thread means none of the pool's: OpenEXR then works in the calling thread.
    if (wanted > 1 && Imf::globalThreadCount() < wanted)
        Imf::setGlobalThreadCount(wanted);
    return wanted > 1 ? wanted : 0;
}

std::string one_line(const char* message)
{
    std::string line(message);
    for (char& c : line)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = ' ';
    while (!line.empty() && (line.back() == ' ' || line.back() == '.'))
        line.pop_back();
    return line;
}

bool is_structural(std::string_view attribute)
{
    return std::find(structural_attributes.begin(), structural_attributes.end(), attribute) !=
           structural_attributes.end();
}

} // namespace lumisweep::exr_detail

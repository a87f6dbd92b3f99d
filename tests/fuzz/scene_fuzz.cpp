// libFuzzer: whatever the bytes of a scene file, parsing ends with a description that round-trips, or with one Error.
#include <cstdlib>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/scene_file.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size)
{
    using namespace lumisweep;
    try {
        const SceneDescription scene = parse_scene({reinterpret_cast<const char*>(data), size}, "fuzz", "/data");
        const std::string text = scene_to_json(scene);
        if (scene_to_json(parse_scene(text, "again", "/data")) != text)
            std::abort();
    } catch (const Error& error) {
        for (const char* c = error.what(); *c != '\0'; ++c)
            if (*c == '\n')
                std::abort();
    }
    return 0;
}

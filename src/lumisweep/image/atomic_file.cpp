#include "lumisweep/image/atomic_file.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <unistd.h>

#include "lumisweep/base/error.h"

namespace lumisweep {

void write_atomically(const std::filesystem::path& path, const std::function<void(std::ofstream&)>& write)
{
    // Unique among threads and processes, so that two writers of one path cannot mix their bytes.
    static std::atomic<unsigned> counter{0};
    std::filesystem::path temporary = path;
    temporary += fmt::format(".{}-{}.tmp", ::getpid(), counter++);

    struct Removal {
        const std::filesystem::path& file;
        bool wanted = true;
        ~Removal()
        {
            std::error_code ignored;
            if (wanted)
                std::filesystem::remove(file, ignored);
        }
    } removal{temporary};

    errno = 0;
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    require(stream.is_open(), "{}: cannot write: {} (check the folder and its permissions)", path.string(),
            std::strerror(errno));
    write(stream);
    stream.close();
    require(stream.good(), "{}: writing failed: {} (is the disk full?)", path.string(), std::strerror(errno));
    std::error_code error;
    std::filesystem::rename(temporary, path, error);
    require(!error, "{}: cannot write: {} (choose another name)", path.string(), error.message());
    removal.wanted = false;
}

} // namespace lumisweep

#include "ceilings.h"

#include <cuda_runtime_api.h>
#include <fmt/format.h>

#include "ceilings_kernel.h"
#include "lumisweep/backends/cuda/device.h"

namespace lumisweep::bench {

namespace {

/// Seconds of work in a stream, the least of a few.
template <class Work>
double least_seconds(const cuda::Stream& stream, const Work& work)
{
    cuda::Event begin, end;
    double least = 1e30;
    for (int i = 0; i < 8; ++i) {
        begin.record(stream);
        work();
        end.record(stream);
        end.wait();
        const double seconds = cuda::Event::seconds(begin, end);
        least = seconds < least ? seconds : least;
    }
    return least;
}

} // namespace

nlohmann::ordered_json measure_ceilings()
{
    const cuda::DeviceInfo info = cuda::open_device();
    const cuda::Stream stream;
    constexpr std::size_t bytes = std::size_t{1} << 30;
    cuda::DeviceArray<std::uint8_t> from(bytes, "a gigabyte"), to(bytes, "a gigabyte");
    cuda::fill_on_device(from.data(), 1, bytes, stream);
    cuda::PinnedArray<std::uint8_t> host(bytes / 4);
    const double copy_s = least_seconds(stream, [&] { cuda::copy_on_device(to.data(), from.data(), bytes, stream); });
    const double upload_s =
        least_seconds(stream, [&] { cuda::copy_to_device(to.data(), host.data(), bytes / 4, stream); });
    const cuda::ProductLoad load{info.multiprocessors * 8, 4096};
    const double products_s = least_seconds(stream, [&] { cuda::multiply_bytes(load, to.data(), stream); });
    int driver = 0, runtime = 0;
    cudaDriverGetVersion(&driver);
    cudaRuntimeGetVersion(&runtime);
    const auto version = [](int v) { return fmt::format("{}.{}", v / 1000, v % 1000 / 10); };
    return {{"name", info.name},
            {"compute_capability", info.compute_capability},
            {"multiprocessors", info.multiprocessors},
            {"memory", info.memory},
            {"driver_of_cuda", version(driver)},
            {"runtime", version(runtime)},
            {"copy_bytes_per_s", 2.0 * static_cast<double>(bytes) / copy_s},
            {"upload_bytes_per_s", static_cast<double>(bytes / 4) / upload_s},
            {"byte_products_per_s", load.products() / products_s}};
}

} // namespace lumisweep::bench

// device.h over the CUDA runtime.
#include "lumisweep/backends/cuda/device.h"

#include <cuda_runtime_api.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

void check(cudaError_t error, const char* what)
{
    if (error == cudaSuccess)
        return;
    // Errors of kernels stay; those of calls are forgotten, so that what follows does not report them again.
    cudaGetLastError();
    fail("device cuda: {} failed: {}, {} (try again, or use --device cpu)", what, cudaGetErrorName(error),
         cudaGetErrorString(error));
}

cudaStream_t stream_of(const Stream& stream) { return static_cast<cudaStream_t>(stream.handle()); }

/// "13.0" of 13000.
std::string version_text(int version) { return fmt::format("{}.{}", version / 1000, version % 1000 / 10); }

} // namespace

DeviceInfo open_device()
{
    constexpr const char* mend = "use --device cpu, or --device auto to fall back to it";
    int driver = 0, runtime = 0, count = 0;
    if (cudaDriverGetVersion(&driver) != cudaSuccess || driver == 0)
        fail("device cuda: there is no NVIDIA driver ({})", mend);
    check(cudaRuntimeGetVersion(&runtime), "asking for the runtime's version");
    const cudaError_t error = cudaGetDeviceCount(&count);
    require(error != cudaErrorInsufficientDriver,
            "device cuda: the driver is of CUDA {} and this program needs {} (update the driver; {})",
            version_text(driver), version_text(runtime), mend);
    require(error == cudaSuccess && count > 0, "device cuda: no usable GPU: {} ({})",
            error == cudaSuccess ? "there is none" : cudaGetErrorString(error), mend);
    cudaDeviceProp properties{};
    check(cudaGetDeviceProperties(&properties, 0), "asking for the device's properties");
    DeviceInfo info;
    info.name = properties.name;
    info.compute_capability = 10 * properties.major + properties.minor;
    info.multiprocessors = properties.multiProcessorCount;
    info.memory = properties.totalGlobalMem;
    require(info.compute_capability >= 75, "device cuda: {} has compute capability {}.{}, below 7.5 ({})", info.name,
            properties.major, properties.minor, mend);
    check(cudaSetDevice(0), "choosing the device");
    check(cudaFree(nullptr), "starting the device");
    return info;
}

std::uint64_t free_device_memory()
{
    std::size_t free = 0, all = 0;
    check(cudaMemGetInfo(&free, &all), "asking for free memory");
    return free;
}

Stream::Stream()
{
    cudaStream_t stream = nullptr;
    check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "making a stream");
    handle_ = stream;
}
Stream::~Stream() { cudaStreamDestroy(static_cast<cudaStream_t>(handle_)); }
void Stream::wait() const { check(cudaStreamSynchronize(stream_of(*this)), "the device's work"); }

Event::Event()
{
    cudaEvent_t event = nullptr;
    check(cudaEventCreate(&event), "making an event");
    handle_ = event;
}
Event::~Event() { cudaEventDestroy(static_cast<cudaEvent_t>(handle_)); }
void Event::record(const Stream& stream)
{
    check(cudaEventRecord(static_cast<cudaEvent_t>(handle_), stream_of(stream)), "recording an event");
}
void Event::wait() const { check(cudaEventSynchronize(static_cast<cudaEvent_t>(handle_)), "the device's work"); }
double Event::seconds(const Event& begin, const Event& end)
{
    float milliseconds = 0.0F;
    check(cudaEventElapsedTime(&milliseconds, static_cast<cudaEvent_t>(begin.handle_),
                               static_cast<cudaEvent_t>(end.handle_)),
          "timing");
    return 1e-3 * static_cast<double>(milliseconds);
}

void* allocate_on_device(std::uint64_t bytes, const char* what)
{
    void* memory = nullptr;
    const cudaError_t error = cudaMalloc(&memory, bytes);
    if (error == cudaErrorMemoryAllocation) {
        cudaGetLastError();
        fail("device cuda: {} needs {} of the GPU's memory and {} are free (a larger visibility.cell, fewer "
             "visibility.directions or a smaller image need less, or use --device cpu)",
             what, format_bytes(bytes), format_bytes(free_device_memory()));
    }
    check(error, "allocating");
    return memory;
}
void release_on_device(void* memory) noexcept { cudaFree(memory); }

void* allocate_pinned(std::uint64_t bytes)
{
    void* memory = nullptr;
    check(cudaMallocHost(&memory, bytes), "allocating page-locked memory");
    return memory;
}
void release_pinned(void* memory) noexcept { cudaFreeHost(memory); }

void copy_to_device(void* to, const void* from, std::size_t bytes, const Stream& stream)
{
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_of(stream)), "copying to the device");
}
void copy_to_host(void* to, const void* from, std::size_t bytes, const Stream& stream)
{
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_of(stream)), "copying from the device");
}
void copy_on_device(void* to, const void* from, std::size_t bytes, const Stream& stream)
{
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream_of(stream)), "copying on the device");
}
void fill_on_device(void* to, std::uint8_t byte, std::size_t bytes, const Stream& stream)
{
    check(cudaMemsetAsync(to, byte, bytes, stream_of(stream)), "filling memory");
}

void check_launch(int error, const char* kernel);
void check_launch(int error, const char* kernel) { check(static_cast<cudaError_t>(error), kernel); }

} // namespace lumisweep::LUMISWEEP_CUDA

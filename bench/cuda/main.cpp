// lumisweep_device_bench [--device cuda|cpu] [--quick]: what studies/cuda.py reports, as JSON on stdout. With --profile
// only an edit and a batch of passes, for a profiler to look at.
#include <cstdio>
#include <ctime>
#include <string_view>

#include <fmt/format.h>

#include "lumisweep/backends/make_backend.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/version.h"
#include "lumisweep/render/backend.h"
#include "measure.h"
#if defined(LUMISWEEP_WITH_CUDA)
#include "ceilings.h"
#endif

namespace {

int run(int argc, char** argv)
{
    using namespace lumisweep;
    std::string device = "cuda";
    bool profile = false;
    bench::DeviceSubject subject;
    subject.sources = {LUMISWEEP_PROJECT, LUMISWEEP_FETCHED_DATA};
    for (int i = 1; i < argc; ++i) {
        const std::string_view argument = argv[i];
        if (argument == "--quick") {
            subject.quick = true;
        } else if (argument == "--profile") {
            profile = true;
        } else if (argument == "--device" && i + 1 < argc) {
            device = argv[++i];
        } else {
            fmt::print(stderr, "usage: lumisweep_device_bench [--device cuda|cpu] [--quick | --profile]\n");
            return 2;
        }
    }
    const std::shared_ptr<Backend> backend = make_backend(device_of(device)).backend;
    subject.make_backend = [backend] { return backend; };
    if (profile) {
        bench::run_for_profiler(subject);
        return 0;
    }
    nlohmann::ordered_json json;
    json["device"] = backend->device();
    json["isa"] = backend->isa();
    json["version"] = version();
    json["time"] = std::time(nullptr);
#if defined(LUMISWEEP_WITH_CUDA)
    if (backend->device() == "cuda")
        json["ceilings"] = bench::measure_ceilings();
#endif
    json["equality"] = bench::measure_equality(subject);
    json["edits"] = bench::measure_edits(subject);
    json["first_sample"] = bench::measure_first_sample(subject);
    json["paths"] = bench::measure_paths(subject);
    json["series"] = bench::measure_series(subject);
    fmt::print("{}\n", json.dump(2));
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
}

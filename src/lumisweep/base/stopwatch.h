// Adds up how long something takes.
#pragma once

#include <chrono>
#include <ctime>

namespace lumisweep {

/// Adds the wall-clock seconds of its life to a counter.
class Stopwatch {
public:
    explicit Stopwatch(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
    ~Stopwatch() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    double& seconds_;
    std::chrono::steady_clock::time_point start_;
};

/// Adds the processor time of its life on this thread, which neither waiting nor other programs lengthen.
class ProcessorStopwatch {
public:
    explicit ProcessorStopwatch(double& seconds) : seconds_(seconds), start_(now()) {}
    ~ProcessorStopwatch() { seconds_ += now() - start_; }
    ProcessorStopwatch(const ProcessorStopwatch&) = delete;
    ProcessorStopwatch& operator=(const ProcessorStopwatch&) = delete;

private:
    static double now()
    {
        std::timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }

    double& seconds_;
    double start_;
};

} // namespace lumisweep

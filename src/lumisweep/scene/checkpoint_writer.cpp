#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

#include "lumisweep/scene/checkpoint.h"

namespace lumisweep {

namespace {

constexpr double largest_share = 0.05; // of the time that passes, for copying and writing

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double thread_cpu_s()
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void copy_film(const Film& from, Film& to)
{
    if (to.width() != from.width() || to.height() != from.height())
        to = Film(from.width(), from.height());
    const FilmArrays& a = from.arrays();
    FilmArrays& b = to.arrays();
    std::copy(a.color_sum.begin(), a.color_sum.end(), b.color_sum.begin());
    std::copy(a.color_sum_squares.begin(), a.color_sum_squares.end(), b.color_sum_squares.begin());
    std::copy(a.block_sum_squares.begin(), a.block_sum_squares.end(), b.block_sum_squares.begin());
    std::copy(a.block_begin.begin(), a.block_begin.end(), b.block_begin.begin());
    std::copy(a.features.begin(), a.features.end(), b.features.begin());
    to.set_draws(from.draws());
    to.set_samples(from.samples());
}

} // namespace

CheckpointWriter::CheckpointWriter(std::filesystem::path file, Fingerprint fingerprint)
    : file_(std::move(file)), fingerprint_(std::move(fingerprint)), thread_([this] { write_pending(); })
{
}

CheckpointWriter::~CheckpointWriter()
{
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void CheckpointWriter::rethrow_failure()
{
    if (failure_)
        std::rethrow_exception(std::exchange(failure_, nullptr));
}

void CheckpointWriter::offer(const Film& film)
{
    std::unique_lock lock(mutex_);
    rethrow_failure();
    const double begin_s = now_s();
    if (pending_ || (begin_s - last_begin_s_) * largest_share < write_cost_s_)
        return;
    lock.unlock(); // the thread is idle: nothing else touches what follows
    const double cpu_begin_s = thread_cpu_s();
    copy_film(film, copy_);
    const double copy_cost_s = thread_cpu_s() - cpu_begin_s;
    lock.lock();
    last_begin_s_ = begin_s;
    write_cost_s_ = copy_cost_s;
    pending_ = true;
    lock.unlock();
    changed_.notify_all();
}

void CheckpointWriter::finish(const Film& film)
{
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !pending_; });
    const bool failed = std::exchange(failure_, nullptr) != nullptr;       // the disk may have room by now
    if (failed || copy_.width() == 0 || copy_.samples() != film.samples()) // else it is on disk already
        write_checkpoint(file_, film, fingerprint_);
}

void CheckpointWriter::write_pending()
{
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return ending_ || pending_; });
        if (!pending_)
            return;
        lock.unlock();
        const double cpu_begin_s = thread_cpu_s();
        std::exception_ptr failure;
        try {
            write_checkpoint(file_, copy_, fingerprint_);
        } catch (...) {
            failure = std::current_exception();
        }
        const double cost_s = thread_cpu_s() - cpu_begin_s;
        lock.lock();
        failure_ = failure;
        write_cost_s_ += cost_s;
        pending_ = false;
        changed_.notify_all();
    }
}

} // namespace lumisweep

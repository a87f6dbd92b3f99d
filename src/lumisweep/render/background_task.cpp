#include "lumisweep/render/background_task.h"

#include <chrono>
#include <utility>

#include "lumisweep/base/cancelled.h"

namespace lumisweep {

BackgroundTask::~BackgroundTask()
{
    if (!thread_.joinable())
        return;
    {
        const std::lock_guard lock(mutex_);
        drop();
        ending_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

/// With the lock held.
void BackgroundTask::drop()
{
    if (running_)
        running_->cancelled.store(true, std::memory_order_relaxed);
    next_.reset();
    error_ = nullptr;
    failed_.store(false, std::memory_order_relaxed);
    busy_.store(running_ != nullptr, std::memory_order_release);
}

void BackgroundTask::start(Work work)
{
    auto task = std::make_shared<Task>();
    task->work = std::move(work);
    if (!thread_.joinable())
        thread_ = std::thread([this] { run(); });
    {
        const std::lock_guard lock(mutex_);
        drop();
        next_ = std::move(task);
        busy_.store(true, std::memory_order_release);
    }
    changed_.notify_all();
}

void BackgroundTask::cancel()
{
    const std::lock_guard lock(mutex_);
    drop();
}

void BackgroundTask::stop()
{
    std::unique_lock lock(mutex_);
    drop();
    changed_.wait(lock, [&] { return !running_; });
}

void BackgroundTask::rethrow()
{
    if (!failed_.load(std::memory_order_acquire))
        return;
    std::exception_ptr error;
    {
        const std::lock_guard lock(mutex_);
        error = std::exchange(error_, nullptr);
        failed_.store(false, std::memory_order_relaxed);
    }
    if (error)
        std::rethrow_exception(error);
}

bool BackgroundTask::wait(const std::atomic<bool>* cancel)
{
    std::unique_lock lock(mutex_);
    const auto idle = [&] { return !running_ && !next_; };
    while (!idle()) {
        if (is_cancelled(cancel))
            return false;
        changed_.wait_for(lock, std::chrono::milliseconds(2));
    }
    return true;
}

void BackgroundTask::run()
{
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || next_; });
        if (ending_)
            return;
        running_ = std::move(next_);
        next_.reset();
        lock.unlock();
        std::exception_ptr error;
        try {
            running_->work(running_->cancelled);
        } catch (...) {
            error = std::current_exception();
        }
        running_->work = nullptr; // what it holds may be large
        lock.lock();
        if (error && !running_->cancelled.load(std::memory_order_relaxed)) {
            error_ = error;
            failed_.store(true, std::memory_order_release);
        }
        running_.reset();
        busy_.store(next_ != nullptr, std::memory_order_release);
        changed_.notify_all();
    }
}

} // namespace lumisweep

// One thread that works on the latest of the tasks that it is given.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace lumisweep {

/// Called from one thread, except that tasks run in theirs.
class BackgroundTask {
public:
    /// Shall return soon when `cancelled` becomes true.
    using Work = std::function<void(const std::atomic<bool>& cancelled)>;

    BackgroundTask() = default;
    ~BackgroundTask();
    BackgroundTask(const BackgroundTask&) = delete;
    BackgroundTask& operator=(const BackgroundTask&) = delete;

    /// Cancels what runs, forgets its error, and has `work` done after it. Does not wait.
    void start(Work work);
    /// Cancels what runs, likewise, without waiting.
    void cancel();
    /// Cancels and waits until nothing runs.
    void stop();
    /// False when all is done, failed or cancelled. No lock is taken.
    bool busy() const { return busy_.load(std::memory_order_acquire); }
    /// What the last task threw, unless it was cancelled; once. No lock is taken when there is nothing.
    void rethrow();
    /// Waits until nothing runs; false when *cancel became true first (looked at every few milliseconds).
    bool wait(const std::atomic<bool>* cancel);

private:
    struct Task {
        Work work;
        std::atomic<bool> cancelled{false};
    };

    void drop();
    void run();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::shared_ptr<Task> running_, next_;
    std::exception_ptr error_;
    bool ending_ = false;
    std::atomic<bool> busy_{false}, failed_{false};
    std::thread thread_; // started by the first task
};

} // namespace lumisweep

// A background thread that works on the latest task: cancelling, errors, ending.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "lumisweep/render/background_task.h"

namespace lumisweep {
namespace {

using Cancelled = const std::atomic<bool>&;

void until_cancelled(Cancelled cancelled)
{
    while (!cancelled.load())
        std::this_thread::yield();
}

TEST(BackgroundTaskThread, WorksBesideItsCaller)
{
    BackgroundTask task;
    EXPECT_FALSE(task.busy());
    EXPECT_TRUE(task.wait(nullptr)); // nothing to wait for
    std::atomic<bool> go = false;
    int result = 0;
    std::thread::id worker;
    task.start([&](Cancelled) {
        while (!go.load())
            std::this_thread::yield();
        worker = std::this_thread::get_id();
        result = 7;
    });
    EXPECT_TRUE(task.busy());
    const std::atomic<bool> impatient = true;
    EXPECT_FALSE(task.wait(&impatient));
    go = true;
    EXPECT_TRUE(task.wait(nullptr));
    EXPECT_FALSE(task.busy());
    EXPECT_EQ(result, 7);
    EXPECT_NE(worker, std::this_thread::get_id());
}

TEST(BackgroundTaskThread, OnlyTheLatestOfManyIsFinished)
{
    BackgroundTask task;
    int finished = -1, count = 0;
    for (int i = 0; i < 50; ++i)
        task.start([&, i](Cancelled cancelled) {
            if (i < 49)
                until_cancelled(cancelled);
            if (!cancelled.load()) {
                finished = i;
                ++count;
            }
        });
    EXPECT_TRUE(task.wait(nullptr));
    EXPECT_EQ(finished, 49);
    EXPECT_EQ(count, 1);
}

TEST(BackgroundTaskThread, CancelAndStopEndIt)
{
    BackgroundTask task;
    std::atomic<int> running = 0;
    const auto work = [&](Cancelled cancelled) {
        ++running;
        until_cancelled(cancelled);
        --running;
    };
    task.stop(); // before there is any
    task.start(work);
    task.stop();
    EXPECT_EQ(running, 0);
    EXPECT_FALSE(task.busy());
    task.start(work);
    task.cancel();
    EXPECT_TRUE(task.wait(nullptr));
    EXPECT_EQ(running, 0);
    EXPECT_FALSE(task.busy());
    task.start(work);
    task.start(work);
    {
        BackgroundTask ends_while_running;
        ends_while_running.start(work);
    }
    task.stop();
    EXPECT_EQ(running, 0);
}

TEST(BackgroundTaskThread, ErrorsReachTheCallerOnce)
{
    BackgroundTask task;
    task.rethrow();
    task.start([](Cancelled) { throw std::runtime_error("no room"); });
    EXPECT_TRUE(task.wait(nullptr));
    EXPECT_FALSE(task.busy());
    EXPECT_THROW(task.rethrow(), std::runtime_error);
    task.rethrow();
    // A task that is of no use any more: its error is not either.
    task.start([](Cancelled) { throw std::runtime_error("no room"); });
    EXPECT_TRUE(task.wait(nullptr));
    task.start([](Cancelled) {});
    EXPECT_TRUE(task.wait(nullptr));
    task.rethrow();
    task.start([](Cancelled cancelled) {
        until_cancelled(cancelled);
        throw std::runtime_error("too late");
    });
    task.stop();
    task.rethrow();
}

} // namespace
} // namespace lumisweep

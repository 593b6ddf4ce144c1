#include "components/runtime/worker.h"

#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sched.h>

namespace rack {
namespace worker_test {

tims::Header numbered(std::uint8_t seq_nr) { return {.seq_nr = seq_nr}; }

// A command in progress until it is released.
class Long {
 public:
  Worker::Work work() {
    return [this] {
      began_.set_value();
      released_.get_future().wait();
    };
  }
  void wait_until_it_began() { began_.get_future().wait(); }
  void release() { released_.set_value(); }

 private:
  std::promise<void> began_;
  std::promise<void> released_;
};

TEST(Worker, ExecutesCommandsInTheirOrder) {
  Worker worker("test");
  std::vector<int> done;
  std::promise<void> last;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(worker.add({}, [&done, i] { done.push_back(i); }));
  ASSERT_TRUE(worker.add({}, [&last] { last.set_value(); }));
  last.get_future().wait();
  EXPECT_EQ(done, (std::vector{0, 1, 2, 3, 4}));
}

TEST(Worker, RefusesWhatItHasNoPlaceFor) {
  Worker worker("test");
  Long first;
  ASSERT_TRUE(worker.add({}, first.work()));
  first.wait_until_it_began();
  for (std::size_t i = 0; i < Worker::kWaitingMax; ++i) ASSERT_TRUE(worker.add({}, [] {})) << i;
  EXPECT_FALSE(worker.add({}, [] {}));
  first.release();
  std::promise<void> done;
  while (!worker.add({}, [&done] { done.set_value(); })) std::this_thread::yield();
  done.get_future().wait();
}

TEST(Worker, ReturnsTheRequestsThatWaitWhenItStops) {
  Worker worker("test");
  Long first;
  bool is_done = false;
  ASSERT_TRUE(worker.add(numbered(1), first.work()));
  first.wait_until_it_began();
  ASSERT_TRUE(worker.add(numbered(2), [&is_done] { is_done = true; }));
  ASSERT_TRUE(worker.add(numbered(3), [&is_done] { is_done = true; }));
  auto stopped = std::async(std::launch::async, [&worker] { return worker.stop(); });
  const auto is_stopping = [&worker] {
    const auto added = worker.add({}, [] {});
    return !added && added.error().detail().find("stopping") != std::string::npos;
  };
  while (!is_stopping()) std::this_thread::yield();
  first.release();
  const auto left = stopped.get();
  EXPECT_FALSE(is_done);
  ASSERT_GE(left.size(), 2U);
  EXPECT_EQ(left[0].seq_nr, 2);
  EXPECT_EQ(left[1].seq_nr, 3);
}

// As the interpreter's lock of Python, which a thread may take again.
using Interpreter = std::recursive_mutex;

// A work that needs the lock to be destroyed.
Worker::Work owned_by(Interpreter& interpreter) {
  return [kept = std::shared_ptr<void>(
              nullptr, [&interpreter](void*) { const std::lock_guard held(interpreter); })] {};
}

TEST(Worker, DestroysWorkWithoutItsMutex) {
  Interpreter interpreter;
  Worker worker("test");
  for (int i = 0; i < 5'000; ++i) {
    const std::lock_guard held(interpreter);
    (void)worker.add({}, owned_by(interpreter));
  }
}

TEST(Worker, DestroysWorkThatWaitsWithoutItsMutex) {
  Interpreter interpreter;
  Worker worker("test");
  Long first;
  ASSERT_TRUE(worker.add({}, first.work()));
  first.wait_until_it_began();
  ASSERT_TRUE(worker.add({}, owned_by(interpreter)));
  std::unique_lock held(interpreter);
  auto stopped = std::async(std::launch::async, [&worker] { return worker.stop(); });
  const auto is_stopping = [&worker] {
    const auto added = worker.add({}, [] {});
    return !added && added.error().detail().find("stopping") != std::string::npos;
  };
  while (!is_stopping()) std::this_thread::yield();
  held.unlock();
  first.release();
  EXPECT_GE(stopped.get().size(), 1U);
}

TEST(Worker, IsAnOrdinaryThreadAlsoForARealTimeTask) {
  Worker worker("test");
  std::promise<int> policy;
  bool is_real_time = false;
  Thread task;
  const auto started = task.start({.name = "task", .priority = kFirstRealTime}, [&] {
    is_real_time = ::sched_getscheduler(0) == SCHED_FIFO;
    EXPECT_TRUE(worker.add({}, [&policy] { policy.set_value(::sched_getscheduler(0)); }));
  });
  if (!started) GTEST_SKIP() << started.error().detail();
  task.join();
  EXPECT_TRUE(is_real_time);
  EXPECT_EQ(policy.get_future().get(), SCHED_OTHER);
}

}  // namespace worker_test
}  // namespace rack

#include "router/io/loop.h"

#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/wakeup.h"

namespace tims::io {
namespace loop_test {

using namespace std::chrono_literals;

constexpr Time kAtOnce{};

class LoopTest : public testing::Test {
 protected:
  os::File ready_ = std::move(*os::make_event_fd());
  os::File other_ = std::move(*os::make_event_fd());
  Loop loop_{};
  int calls_ = 0;
};

TEST_F(LoopTest, CallsAsLongAsADescriptorIsReady) {
  const Watch watch(loop_, ready_.get(), [&](Ready ready) {
    EXPECT_TRUE(ready.to_read);
    EXPECT_FALSE(ready.to_write);
    ++calls_;
  });
  loop_.run_once(kAtOnce);
  EXPECT_EQ(calls_, 0);
  os::signal_event_fd(ready_.get());
  loop_.run_once(kNever);
  loop_.run_once(kNever);
  EXPECT_EQ(calls_, 2);
  os::drain_event_fd(ready_.get());
  loop_.run_once(kAtOnce);
  EXPECT_EQ(calls_, 2);
}

// The counter is not read: only a further signal is an arrival.
TEST_F(LoopTest, CallsOncePerArrivalWhenAllIsTaken) {
  std::optional<Watch> watch;
  bool takes_all = true;
  watch.emplace(loop_, ready_.get(), [&](Ready) {
    ++calls_;
    if (takes_all) watch->all_taken();
  });
  for (int arrival = 1; arrival <= 3; ++arrival) {
    os::signal_event_fd(ready_.get());
    while (calls_ < arrival) loop_.run_once(kNever);
    for (int i = 0; i < 3; ++i) loop_.run_once(kAtOnce);
    EXPECT_EQ(calls_, arrival);
  }
  takes_all = false;
  os::signal_event_fd(ready_.get());
  while (calls_ < 6) loop_.run_once(kNever);
}

// It arrived after its owner had looked, and before the watch waited again.
TEST_F(LoopTest, AnArrivalDuringTheCallbackIsNotLost) {
  std::optional<Watch> watch;
  watch.emplace(loop_, ready_.get(), [&](Ready) {
    if (++calls_ < 3) os::signal_event_fd(ready_.get());
    watch->all_taken();
  });
  os::signal_event_fd(ready_.get());
  while (calls_ < 3) loop_.run_once(kNever);
  for (int i = 0; i < 3; ++i) loop_.run_once(kAtOnce);
  EXPECT_EQ(calls_, 3);
}

TEST_F(LoopTest, CallsOnlyForTheInterest) {
  int reads = 0;
  int writes = 0;
  Watch watch(
      loop_, ready_.get(),
      [&](Ready ready) {
        EXPECT_NE(ready.to_read, ready.to_write);
        ready.to_read ? ++reads : ++writes;
      },
      Interest::kNothing);
  os::signal_event_fd(ready_.get());
  loop_.run_once(kAtOnce);
  EXPECT_EQ(reads + writes, 0);
  watch.set(Interest::kWriting);
  while (writes < 2) loop_.run_once(kNever);
  EXPECT_EQ(reads, 0);
  watch.set(Interest::kBoth);
  while (reads < 2 || writes < 4) loop_.run_once(kNever);
  watch.set(Interest::kNothing);
  reads = writes = 0;
  for (int i = 0; i < 3; ++i) loop_.run_once(kAtOnce);
  EXPECT_EQ(reads + writes, 0);
}

TEST_F(LoopTest, ABrokenDescriptorIsReady) {
  int sockets[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, sockets), 0);
  const os::File one(sockets[0]);
  os::File two(sockets[1]);
  const Watch watch(loop_, one.get(), [&](Ready ready) {
    EXPECT_TRUE(ready.to_read);
    ++calls_;
  });
  two.reset();
  loop_.run_once(kNever);
  loop_.run_once(kNever);
  EXPECT_EQ(calls_, 2);
}

// What it captures stays until it returns.
TEST_F(LoopTest, AWatchMayEndItself) {
  std::optional<Watch> watch;
  watch.emplace(loop_, ready_.get(), [&, text = std::string(100, 'x')](Ready) {
    watch.reset();
    calls_ += static_cast<int>(text.size());
  });
  os::signal_event_fd(ready_.get());
  loop_.run_once(kNever);
  loop_.run_once(kAtOnce);
  EXPECT_EQ(calls_, 100);
}

TEST_F(LoopTest, AWatchMayEndAnotherThatIsReadyToo) {
  std::optional<Watch> one;
  std::optional<Watch> two;
  one.emplace(loop_, ready_.get(), [&](Ready) {
    ++calls_;
    two.reset();
  });
  two.emplace(loop_, other_.get(), [&](Ready) {
    ++calls_;
    one.reset();
  });
  os::signal_event_fd(ready_.get());
  os::signal_event_fd(other_.get());
  loop_.run_once(kNever);
  EXPECT_EQ(calls_, 1);
}

TEST_F(LoopTest, TimersComeInTheirOrderAndOnce) {
  std::string order;
  Timer late(loop_, [&] { order += 'l'; });
  Timer early(loop_, [&] { order += 'e'; });
  Timer never(loop_, [&] { order += 'n'; });
  const Time now = os::now();
  late.set(now + 2ms);
  early.set(now + 1ms);
  never.set(now + 1ms);
  never.cancel();
  while (order.size() < 2) loop_.run_once(kNever);
  EXPECT_GE(os::now(), now + 2ms);
  loop_.run_once(kAtOnce);
  EXPECT_EQ(order, "el");
}

TEST_F(LoopTest, ATimerIsSetAnewOrEndsItself) {
  std::optional<Timer> timer;
  timer.emplace(loop_, [&] {
    ++calls_;
    calls_ < 3 ? timer->set(os::now()) : timer.reset();
  });
  timer->set(os::now());
  while (timer) loop_.run_once(kNever);
  EXPECT_EQ(calls_, 3);
}

TEST_F(LoopTest, WhatIsPostedWaitsForNobodyAndNotForItself) {
  loop_.post([&] {
    ++calls_;
    loop_.post([&] { ++calls_; });
  });
  loop_.run_once(kNever);
  EXPECT_EQ(calls_, 1);
  loop_.run_once(kNever);
  EXPECT_EQ(calls_, 2);
}

TEST_F(LoopTest, DeadlinesAreKeptAlsoWhenSomethingIsAlwaysReady) {
  const Time at = os::now() + 2ms;
  bool reached = false;
  loop_.watch({.next = [&] { return reached ? kNever : at; },
               .on_timeout =
                   [&](Time now) {
                     EXPECT_GE(now, at);
                     reached = true;
                   }});
  const Watch watch(loop_, ready_.get(), [&](Ready) { ++calls_; });
  os::signal_event_fd(ready_.get());
  while (!reached) loop_.run_once(kNever);
  EXPECT_GT(calls_, 1);
}

TEST_F(LoopTest, EachTimeOutIsATurn) {
  int turns = 0;
  loop_.at_turn_end([&](Time) { ++turns; });
  Timer timer(loop_, [&] { ++calls_; });
  timer.set(os::now());
  while (calls_ == 0) loop_.run_once(kNever);
  EXPECT_EQ(turns, 1);
}

TEST_F(LoopTest, RunEndsWhenItIsToStop) {
  Timer timer(loop_, [&] { loop_.stop(); });
  timer.set(os::now() + 1ms);
  loop_.run();
}

}  // namespace loop_test
}  // namespace tims::io

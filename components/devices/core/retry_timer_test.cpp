#include "rack/devices/retry_timer.h"

#include <gtest/gtest.h>

#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace retry_timer_test {

using namespace std::chrono_literals;

constexpr Time kBegin{1000s};
constexpr Duration kAnswerTime = 100ms;
constexpr int kAttempts = 3;
constexpr std::array kByte = {std::byte{'?'}};

TEST(RetryTimerTest, IsDueOnceAndNotBeforeItsTime) {
  RetryTimer timer;
  EXPECT_EQ(timer.due(), tims::kNever);
  EXPECT_FALSE(timer.take_due(kBegin));
  for (const Duration late : {0ns, 1ns, Duration(1h)}) {
    timer.sent(kBegin, kAnswerTime);
    EXPECT_EQ(timer.due(), kBegin + kAnswerTime);
    EXPECT_FALSE(timer.take_due(kBegin + kAnswerTime - 1ns));
    EXPECT_TRUE(timer.take_due(kBegin + kAnswerTime + late));
    EXPECT_EQ(timer.due(), tims::kNever);
    EXPECT_FALSE(timer.take_due(kBegin + kAnswerTime + late));
  }
}

TEST(RetryTimerTest, TheShortestAndTheLongestTime) {
  RetryTimer timer;
  timer.sent(kBegin, 0ns);
  EXPECT_TRUE(timer.take_due(kBegin));
  const Duration longest = tims::kNever - kBegin - 1ns;
  timer.sent(kBegin, longest);
  EXPECT_EQ(timer.due(), kBegin + longest);
  for (const Duration forever : {longest + 1ns, longest + 2ns, tims::kForever}) {
    timer.sent(kBegin, forever);
    EXPECT_EQ(timer.due(), tims::kNever);
    EXPECT_FALSE(timer.take_due(tims::kNever - 1ns));
  }
}

TEST(RetryTimerTest, CountsWhatWasSent) {
  RetryTimer timer;
  EXPECT_FALSE(timer.may_repeat(0));
  for (int attempts = 0; attempts < kAttempts; ++attempts) {
    EXPECT_EQ(timer.attempts(), attempts);
    EXPECT_FALSE(timer.may_repeat(attempts));
    EXPECT_TRUE(timer.may_repeat(attempts + 1));
    timer.sent(kBegin, kAnswerTime);
  }
  EXPECT_FALSE(timer.may_repeat(kAttempts));
}

TEST(RetryTimerTest, APauseIsNoAttempt) {
  RetryTimer timer;
  timer.sent(kBegin, kAnswerTime);
  timer.wait_until(kBegin + 1s);
  EXPECT_EQ(timer.due(), kBegin + 1s);
  EXPECT_TRUE(timer.take_due(kBegin + 1s));
  timer.wait_until(kBegin);  // in the past: at once
  EXPECT_TRUE(timer.take_due(kBegin + 1s));
  EXPECT_EQ(timer.attempts(), 1);
}

TEST(RetryTimerTest, StoppingKeepsTheAttemptsAndResettingDoesNot) {
  RetryTimer timer;
  timer.sent(kBegin, kAnswerTime);
  timer.stop();
  EXPECT_FALSE(timer.take_due(kBegin + 1h));
  EXPECT_EQ(timer.attempts(), 1);
  timer.sent(kBegin, kAnswerTime);
  timer.reset();
  EXPECT_FALSE(timer.take_due(kBegin + 1h));
  EXPECT_EQ(timer.attempts(), 0);
}

// --- in a dialogue, at a line with a virtual clock

class Asker final : public Dialogue {
 public:
  void start(Time now, Output& out) override {
    clear_failure();
    timer_.reset();
    is_answered = false;
    ask(now, out);
  }
  void on_arrival(const Arrival& arrival, Output&) override {
    last = arrival.last;
    if (refuses) return fail(tims::Errc::kAnsweredError, "wrong answer");
    is_answered = true;
    timer_.stop();
  }
  void on_timeout(Time now, Output& out) override {
    if (!timer_.take_due(now)) return;
    last = now;
    if (timer_.may_repeat(kAttempts)) return ask(now, out);
    fail(tims::Errc::kTimeout, "no answer");
  }

  bool refuses = false;  // fails at any answer
  bool is_answered = false;
  Time last{};  // time of the last event
  int sent = 0;

 private:
  void ask(Time now, Output& out) {
    ++sent;
    out.send(kByte);
    timer_.sent(now, kAnswerTime);
  }
};

class Answerer final : public Dialogue {
 public:
  explicit Answerer(Duration delay) : delay_(delay) {}
  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output&) override {
    timer_.wait_until(arrival.last + delay_);
  }
  void on_timeout(Time now, Output& out) override {
    if (timer_.take_due(now)) out.send(kByte);
  }

 private:
  Duration delay_;
};

struct Conversed {
  Asker host;
  Answerer device;
  emulator::VirtualLine line{host, device, {}};
  int lost = 0;  // requests

  // The first `to_lose` requests are lost, and every answer takes `delay`.
  explicit Conversed(int to_lose, Duration delay = 0ns, bool refuses = false) : device(delay) {
    host.refuses = refuses;
    line.set_lose([this, to_lose](bool from_host, std::span<const std::byte>) {
      return from_host && lost++ < to_lose;
    });
    line.start();
    line.run(10s);
  }
};

TEST(RetryTimerTest, EachAttemptMayBeAnsweredUpToTheLast) {
  for (int lost = 0; lost < kAttempts; ++lost) {
    const Conversed run(lost);
    EXPECT_FALSE(run.host.failure());
    EXPECT_TRUE(run.host.is_answered);
    EXPECT_EQ(run.host.sent, lost + 1);
    EXPECT_EQ(run.host.last, kBegin + lost * kAnswerTime);
    EXPECT_EQ(run.host.next_timeout(), tims::kNever);
  }
}

TEST(RetryTimerTest, GivesUpAfterTheLastAndTriesAsOftenAfterTheNextStart) {
  Conversed run(2 * kAttempts);
  for (int start = 1; start <= 2; ++start) {
    ASSERT_TRUE(run.host.failure());
    EXPECT_EQ(run.host.sent, start * kAttempts);
    EXPECT_EQ(run.host.next_timeout(), tims::kNever);
    const Time begin = start == 1 ? kBegin : kBegin + 10s;
    EXPECT_EQ(run.host.last, begin + kAttempts * kAnswerTime);
    run.line.start_host();
    run.line.run(10s);
  }
  EXPECT_FALSE(run.host.failure());
  EXPECT_TRUE(run.host.is_answered);
}

TEST(RetryTimerTest, AFailureStopsIt) {
  const Conversed run(0, kAnswerTime - 1ms, true);
  EXPECT_TRUE(run.host.failure());
  EXPECT_EQ(run.host.last, kBegin + kAnswerTime - 1ms);
  EXPECT_EQ(run.host.sent, 1);
  EXPECT_EQ(run.host.next_timeout(), tims::kNever);
}

TEST(RetryTimerTest, ALateAnswerAfterTheFailureStartsNothing) {
  const Conversed run(kAttempts - 1, kAnswerTime + 1ms);
  EXPECT_TRUE(run.host.is_answered);
  EXPECT_EQ(run.host.last, kBegin + kAttempts * kAnswerTime + 1ms);
  EXPECT_TRUE(run.host.failure());
  EXPECT_EQ(run.host.sent, kAttempts);
  EXPECT_EQ(run.host.next_timeout(), tims::kNever);
}

}  // namespace retry_timer_test
}  // namespace rack::device

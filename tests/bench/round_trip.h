// Roles of a round trip: ping sends, waits and measures; echo returns each message. Both sleep
// while they wait, without a timer, which may cost as much as a hand-over. If a message is lost,
// the time limit of the crew ends the measurement.
#pragma once

#include <cstdio>
#include <vector>

#include "libtims/os/clock.h"
#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/metrics.h"
#include "tests/bench/plan.h"
#include "tests/bench/usage.h"

namespace tims::bench {

template <Link L>
class Ping {
 public:
  Ping(const Plan& plan, L& link) : plan_(plan), link_(link), payload_(plan.payload) {}

  bool run() {
    if (!meet()) return false;
    rounds(kWarmUp, kWarmUpRounds);
    samples_.clear();
    const Usage before = own_usage();
    rounds(plan_.seconds, kRounds);
    print_usage(before, samples_.size());
    print_latencies(samples_);
    link_.send(payload_.with({.kind = Kind::kEnd}));
    link_.flush();
    return true;
  }

 private:
  static constexpr Duration kWarmUp = std::chrono::milliseconds(60);
  static constexpr std::size_t kWarmUpRounds = 1000;
  static constexpr std::size_t kRounds = 1'000'000;
  static constexpr Duration kPatience = std::chrono::seconds(1);

  bool meet() {
    for (int tries = 0; tries < 10; ++tries) {
      if (exchange({.kind = Kind::kHello}, kPatience)) return true;
    }
    std::fprintf(stderr, "ping: no answer\n");
    return false;
  }

  void rounds(Duration duration, std::size_t count_max) {
    samples_.reserve(count_max);
    Time now = os::now();
    const Time until = now + duration;
    while (now < until && samples_.size() < count_max) {
      const Time start = now;
      exchange({.kind = Kind::kData, .seq = ++seq_}, kForever);
      now = os::now();
      samples_.push_back(now - start);
    }
  }

  bool exchange(const Head& question, Duration patience) {
    bool answered = false;
    link_.send(payload_.with(question));
    link_.flush();
    do {
      link_.receive(patience, [&](std::span<const std::byte> answer) {
        const Head head = head_of(answer);
        answered |= head.kind == question.kind && head.seq == question.seq;
      });
    } while (!answered && patience == kForever);
    return answered;
  }

  const Plan& plan_;
  L& link_;
  Payload payload_;
  std::vector<Duration> samples_;
  std::uint64_t seq_ = 0;
};

template <Link L>
class Echo {
 public:
  Echo(const Plan& plan, L& link) : plan_(plan), link_(link) {}

  bool run() {
    Usage before;
    std::uint64_t rounds = 0;
    bool ended = false;
    while (!ended) {
      link_.receive(kForever, [&](std::span<const std::byte> message) {
        const Head head = head_of(message);
        if (head.kind == Kind::kEnd) ended = true;
        if (head.kind == Kind::kData && rounds++ == 0) before = own_usage();
        if (!ended) link_.send(message);
      });
      link_.flush();
    }
    if (rounds > 0) {
      const Usage spent = own_usage() - before;
      print_metric(raw::kCpu, spent.cpu_s);
      print_metric(raw::kSleeps, spent.sleeps);
    }
    return ended;
  }

 private:
  const Plan& plan_;
  L& link_;
};

}  // namespace tims::bench

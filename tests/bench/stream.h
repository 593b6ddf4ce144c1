// Roles of a stream: a source sends as fast as permitted, sinks count. On links without
// back-pressure the sinks grant credit a quarter of a window at a time, as users must.
#pragma once

#include <algorithm>
#include <cstdio>
#include <vector>

#include "libtims/os/clock.h"
#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/metrics.h"
#include "tests/bench/plan.h"
#include "tests/bench/usage.h"

namespace tims::bench {

// Reading the clock costs as much as a small message, so it is read only for every 64th.
inline constexpr std::uint64_t kClockEvery = 64;
inline constexpr std::size_t kLargePayload = 16 << 10;
constexpr bool time_to_look(std::uint64_t count, std::size_t payload) {
  return count % kClockEvery == 0 || payload > kLargePayload;
}

template <Link L>
class Source {
 public:
  Source(const Plan& plan, L& link)
      : plan_(plan), link_(link), payload_(plan.payload), receivers_(plan.subscribers) {}

  bool run() {
    const bool met = wait_for_all(&Receiver::ready, {.kind = Kind::kHello}, kMeetPatience);
    if (!met) return complain("have answered");
    const Usage before = own_usage();
    stream();
    const bool ended = wait_for_all(&Receiver::done, {.kind = Kind::kEnd, .seq = sent_}, kOnce);
    const Usage spent = own_usage() - before;
    print_metric(raw::kCpu, spent.cpu_s);
    print_metric(raw::kSleeps, spent.sleeps);
    return ended || complain("have ended");
  }

 private:
  static constexpr Duration kPatience = std::chrono::seconds(12);
  static constexpr Duration kMeetPatience = std::chrono::milliseconds(200);
  static constexpr Duration kOnce =
      kPatience;  // kEnd is sent once, so that it does not replace data

  struct Receiver {
    bool ready = false;
    bool done = false;
    std::uint64_t acked = 0;
  };

  void stream() {
    Time now = os::now();
    const Time until = now + plan_.seconds;
    const std::uint64_t window = link_.needs_credit() ? plan_.window : ~std::uint64_t{0};
    while (now < until) {
      if (sent_ - acked_ >= window && !wait_for_credit(window)) break;
      if (time_to_look(sent_, plan_.payload)) now = os::now();
      if (!link_.send(payload_.with({.kind = Kind::kData, .seq = sent_ + 1}))) break;
      ++sent_;
    }
  }

  bool wait_for_credit(std::uint64_t window) {
    const Time give_up = os::now() + kPatience;
    link_.flush();
    while (sent_ - acked_ >= window) {
      receive(std::chrono::seconds(1));
      if (sent_ - acked_ >= window && os::now() >= give_up) return complain("give credit");
    }
    return true;
  }

  // Sends `head` again after each `repeat` until `flag` is set for all receivers.
  bool wait_for_all(bool Receiver::*flag, const Head& head, Duration repeat) {
    const auto all = [&] {
      return std::all_of(receivers_.begin(), receivers_.end(),
                         [flag](const Receiver& r) { return r.*flag; });
    };
    const Time give_up = os::now() + kPatience;
    while (!all() && os::now() < give_up) {
      link_.send(payload_.with(head));
      link_.flush();
      const Time again = std::min(os::now() + repeat, give_up);
      while (!all() && os::now() < again) receive(std::chrono::milliseconds(50));
    }
    return all();
  }

  void receive(Duration timeout) {
    link_.receive(timeout, [this](std::span<const std::byte> answer) {
      const Head head = head_of(answer);
      if (head.receiver >= receivers_.size()) return;
      Receiver& receiver = receivers_[head.receiver];
      receiver.ready |= head.kind == Kind::kReady;
      receiver.done |= head.kind == Kind::kDone;
      if (head.kind != Kind::kAck) return;
      receiver.acked = std::max(receiver.acked, head.seq);
      acked_ = std::min_element(receivers_.begin(), receivers_.end(), [](auto& a, auto& b) {
                 return a.acked < b.acked;
               })->acked;
    });
  }

  bool complain(const char* what) const {
    std::fprintf(stderr, "source: not all of %zu sinks %s; %llu sent, %llu acknowledged\n",
                 receivers_.size(), what, static_cast<unsigned long long>(sent_),
                 static_cast<unsigned long long>(acked_));
    return false;
  }

  const Plan& plan_;
  L& link_;
  Payload payload_;
  std::vector<Receiver> receivers_;
  std::uint64_t sent_ = 0;
  std::uint64_t acked_ = 0;  // acknowledged by all receivers
};

template <Link L>
class Sink {
 public:
  Sink(const Plan& plan, L& link)
      : plan_(plan),
        link_(link),
        reply_(kReplyBytes),
        credit_every_(link.needs_credit() ? std::max<std::uint64_t>(1, plan.window / 4) : 0) {}

  bool run() {
    const Time until = os::now() + plan_.seconds + std::chrono::seconds(30);
    while (!ended_ && os::now() < until) {
      link_.receive(std::chrono::seconds(1),
                    [this](std::span<const std::byte> message) { take(message); });
    }
    reply(Kind::kDone, total_);
    print_usage(before_, received_);
    print_metric("lost", static_cast<double>(total_) - static_cast<double>(received_));
    print_rate();
    return ended_;
  }

 private:
  void take(std::span<const std::byte> message) {
    const Head head = head_of(message);
    if (head.kind == Kind::kData) return take_data(head);
    if (head.kind == Kind::kHello) reply(Kind::kReady, 0);
    if (head.kind == Kind::kEnd) {
      ended_ = true;
      total_ = head.seq;
    }
  }

  void take_data(const Head& head) {
    if (received_ == 0) begin();
    ++received_;
    if (time_to_look(received_, plan_.payload)) look_at_the_clock();
    if (credit_every_ != 0 && head.seq % credit_every_ == 0) reply(Kind::kAck, head.seq);
  }

  void begin() {
    before_ = own_usage();
    warm_until_ = os::now() + plan_.seconds / 4;
  }

  // The rate is measured from the end of the warm-up on.
  void look_at_the_clock() {
    last_ = {os::now(), received_};
    if (first_.count == 0 && last_.at >= warm_until_) first_ = last_;
  }

  void print_rate() const {
    if (first_.count == 0 || last_.count <= first_.count) return;
    const double seconds = std::chrono::duration<double>(last_.at - first_.at).count();
    const double rate = static_cast<double>(last_.count - first_.count) / seconds;
    print_metric("msgs_per_s", rate);
    print_metric("mb_per_s", rate * static_cast<double>(plan_.payload) * 1e-6);
  }

  void reply(Kind kind, std::uint64_t seq) {
    link_.send(reply_.with({.kind = kind, .receiver = plan_.index, .seq = seq}));
    link_.flush();
  }

  struct Mark {
    Time at{};
    std::uint64_t count = 0;
  };

  const Plan& plan_;
  L& link_;
  Payload reply_;
  const std::uint64_t credit_every_;
  std::uint64_t received_ = 0;
  std::uint64_t total_ = 0;
  bool ended_ = false;
  Mark first_;
  Mark last_;
  Time warm_until_{};
  Usage before_;
};

}  // namespace tims::bench

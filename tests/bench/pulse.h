// Roles for the latency in one direction: a pulse sends the time periodically, a gauge measures the
// latency at arrival. Two hosts on one machine have the same clock.
#pragma once

#include <cstdio>
#include <thread>
#include <vector>

#include "libtims/os/clock.h"
#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/metrics.h"
#include "tests/bench/plan.h"

namespace tims::bench {

template <Link L>
class Pulse {
 public:
  Pulse(const Plan& plan, L& link) : plan_(plan), link_(link), payload_(plan.payload) {}

  bool run() {
    constexpr Duration kMeetPatience = std::chrono::milliseconds(200);
    constexpr Duration kOnce = kPatience;
    if (!ask({.kind = Kind::kHello}, Kind::kReady, kMeetPatience)) return complain("answers");
    const std::uint64_t sent = beat();
    return ask({.kind = Kind::kEnd, .seq = sent}, Kind::kDone, kOnce) || complain("has ended");
  }

 private:
  static constexpr Duration kPatience = std::chrono::seconds(12);

  std::uint64_t beat() {
    std::uint64_t sent = 0;
    Time now = os::now();
    Time next = now;
    for (const Time until = now + plan_.seconds; now < until; ++sent, next += plan_.every) {
      if (next > now) std::this_thread::sleep_for(next - now);
      now = os::now();
      send_head(
          {.kind = Kind::kData, .seq = static_cast<std::uint64_t>(now.time_since_epoch().count())});
    }
    return sent;
  }

  // Sends `question` again after each `repeat` until an answer of the kind `wanted` arrives.
  bool ask(const Head& question, Kind wanted, Duration repeat) {
    bool answered = false;
    for (const Time give_up = os::now() + kPatience; !answered && os::now() < give_up;) {
      send_head(question);
      link_.receive(repeat, [&](std::span<const std::byte> answer) {
        answered |= head_of(answer).kind == wanted;
      });
    }
    return answered;
  }

  void send_head(const Head& head) {
    link_.send(payload_.with(head));
    link_.flush();
  }

  static bool complain(const char* what) {
    std::fprintf(stderr, "pulse: no gauge %s\n", what);
    return false;
  }

  const Plan& plan_;
  L& link_;
  Payload payload_;
};

template <Link L>
class Gauge {
 public:
  Gauge(const Plan& plan, L& link) : plan_(plan), link_(link), reply_(kReplyBytes) {}

  bool run() {
    const Time until = os::now() + plan_.seconds + std::chrono::seconds(30);
    while (!ended_ && os::now() < until) {
      link_.receive(std::chrono::seconds(1),
                    [this](std::span<const std::byte> message) { take(head_of(message)); });
    }
    print_metric("lost", static_cast<double>(total_) - static_cast<double>(received_));
    print_latencies(samples_);
    return ended_;
  }

 private:
  void take(const Head& head) {
    if (head.kind == Kind::kData) return note(Time(Duration(head.seq)));
    if (head.kind == Kind::kHello) send_head(Kind::kReady);
    if (head.kind != Kind::kEnd) return;
    ended_ = true;
    total_ = head.seq;
    send_head(Kind::kDone);
  }

  // The first quarter of the time is warm-up, as for streams.
  void note(Time sent) {
    const Time now = os::now();
    if (received_++ == 0) warm_until_ = now + plan_.seconds / 4;
    if (now >= warm_until_) samples_.push_back(now - sent);
  }

  void send_head(Kind kind) {
    link_.send(reply_.with({.kind = kind}));
    link_.flush();
  }

  const Plan& plan_;
  L& link_;
  Payload reply_;
  std::vector<Duration> samples_;
  std::uint64_t received_ = 0;
  std::uint64_t total_ = 0;
  bool ended_ = false;
  Time warm_until_{};
};

}  // namespace tims::bench

#include "router/io/loop.h"

#include <algorithm>

#include "os/clock.h"

namespace tims::io {

// One thread, and nothing posts from another one: no locks.
Loop::Loop() : context_(BOOST_ASIO_CONCURRENCY_HINT_UNSAFE), timer_(context_) {}

void Loop::end_turn(Time began) {
  for (const auto& step : steps_) step(began);
  arm_timer();
  longest_turn_ = std::max(longest_turn_, os::now() - began);
}

void Loop::run() {
  arm_timer();
  context_.run();
}

void Loop::arm_timer() {
  Time next = kNever;
  for (const Deadlines& d : deadlines_) next = std::min(next, d.next());
  // A deadline that has moved away costs nothing: the timer finds nothing to do and is set anew.
  if (next >= armed_) return;
  armed_ = next;
  timer_.expires_at(std::chrono::steady_clock::time_point(next.time_since_epoch()));
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) on_timer();
  });
}

void Loop::on_timer() {
  const Time now = os::now();
  armed_ = kNever;
  for (const Deadlines& d : deadlines_) {
    if (d.next() <= now) d.on_timeout(now);
  }
  end_turn(now);
}

}  // namespace tims::io

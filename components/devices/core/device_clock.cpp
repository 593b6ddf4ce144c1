#include "rack/devices/device_clock.h"

#include <algorithm>

namespace rack::device {

Time stamped_at(Duration stamp, Duration wall, Time now) {
  constexpr Duration kLongest = std::chrono::seconds(1);
  const Duration ago = wall - stamp;
  return ago < Duration(0) || ago > kLongest ? now : now - ago;
}

void DeviceClock::reset() {
  last_.reset();
  turns_ = 0;
  now_ = before_ = {};
}

Time DeviceClock::to_host(std::uint64_t counter, Time arrival) {
  if (last_ && counter < *last_) {
    // The counter wrapped, or the device was restarted. Between two messages the counter advances
    // by less than half its range.
    const bool is_turn = *last_ - counter > ticks_of_turn_ / 2;
    if (!is_turn) reset();
    if (is_turn) ++turns_;
  }
  last_ = counter;
  // Counters may have any range: only differences matter, modulo 2^64.
  const auto device =
      static_cast<std::uint64_t>(tick_.count()) * (turns_ * ticks_of_turn_ + counter);
  const auto received = static_cast<std::uint64_t>(arrival.time_since_epoch().count());
  const auto difference = static_cast<std::int64_t>(received - device);
  if (!now_.least || arrival - now_.begin > kWindow) {
    before_ = now_;
    now_ = {.begin = arrival, .least = difference};
  }
  now_.least = std::min(*now_.least, difference);
  const std::int64_t offset = std::min(*now_.least, before_.least.value_or(*now_.least));
  const std::uint64_t late =
      static_cast<std::uint64_t>(difference) - static_cast<std::uint64_t>(offset);
  constexpr auto kLatest = static_cast<std::uint64_t>(Duration(kWindow).count());
  return arrival - Duration(static_cast<std::int64_t>(std::min(late, kLatest)));
}

Time TurnClock::to_host(Time arrival) {
  constexpr Duration kPause = std::chrono::seconds(2);  // after such a gap the clock is reset
  constexpr std::int64_t kSlow = 200;                   // 1/200 of the elapsed time
  const Duration since = last_ ? arrival - *last_ : kPause;
  if (since < Duration(0) || since >= kPause) {
    last_ = arrival;
    return arrival;
  }
  const std::int64_t turns = std::max<std::int64_t>(1, (since + turn_ / 2) / turn_);
  const Duration even = turns * turn_;
  last_ = *last_ + std::min(since, even + even / kSlow);
  return *last_;
}

}  // namespace rack::device

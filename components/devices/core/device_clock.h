// When a device measured, in the host's time.
//
// A device that counts its own time says when it measured without any jitter, but its clock began
// somewhere and runs a little fast or slow. What it sends arrives late, by some delay that varies
// and never is negative. So the smallest difference of arrival and counter in the last seconds is
// the best guess of what lies between the two clocks: the message that was least delayed gave it.
// Two windows take turns, so that an old guess is forgotten and drift is followed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

// Of that many bytes on a serial line with one start and one stop bit.
constexpr Duration line_time(std::size_t bytes, std::uint32_t baud) {
  constexpr std::int64_t kBitsOfByte = 10;
  return Duration(std::chrono::seconds(1)) * (kBitsOfByte * static_cast<std::int64_t>(bytes)) /
         baud;
}

// The host's time of what the kernel has stamped with the clock on the wall: how long ago that was
// counts, and at most a second of it, for that clock may have been set meanwhile.
Time stamped_at(Duration stamp, Duration wall, Time now);

class DeviceClock {
 public:
  // `tick`: of the counter, which begins anew after `ticks_of_turn`.
  DeviceClock(Duration tick, std::uint64_t ticks_of_turn)
      : tick_(tick), ticks_of_turn_(ticks_of_turn) {}

  // When the device's counter stood there: never later than `arrival`, when we heard of it. A
  // counter that jumps back is a device that was started anew.
  Time to_host(std::uint64_t counter, Time arrival);
  void reset();

 private:
  struct Window {
    Time begin{};
    std::optional<std::int64_t> least;  // arrival less counter, ns
  };

  static constexpr Duration kWindow = std::chrono::seconds(5);

  Duration tick_;
  std::uint64_t ticks_of_turn_;
  std::optional<std::uint64_t> last_;
  std::uint64_t turns_ = 0;
  Window now_;
  Window before_;
};

// The same for a device that counts nothing but sends after each turn of its mirror, or some of
// them: the turn is the clock. What comes sooner than a whole number of turns after the last was
// late before, and sets the clock; what comes later is late, or the mirror is a little slow: by
// half a percent at most.
class TurnClock {
 public:
  explicit TurnClock(Duration turn) : turn_(turn) {}

  // When it would have come without delay: never later than `arrival`.
  Time to_host(Time arrival);
  void reset() { last_.reset(); }

 private:
  Duration turn_;
  std::optional<Time> last_{};
};

}  // namespace rack::device

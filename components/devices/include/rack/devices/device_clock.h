// Converts the time of a measurement from a device's clock to the host's clock.
//
// The counter of a device has no jitter, but an unknown offset and a small drift. Messages arrive
// with a varying delay that is never negative. The smallest difference of arrival time and counter
// over the last seconds is therefore the best estimate of the offset: it comes from the message
// with the least delay. Two alternating windows discard old estimates and so follow the drift.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "tims/time.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

using tims::Duration;
using tims::Time;

// Transmission time of that many bytes on a serial line with one start and one stop bit.
constexpr Duration line_time(std::size_t bytes, std::uint32_t baud) {
  constexpr std::int64_t kBitsOfByte = 10;
  return Duration(std::chrono::seconds(1)) * (kBitsOfByte * static_cast<std::int64_t>(bytes)) /
         baud;
}

// Converts a wall-clock stamp of the kernel to the host's monotonic time. Only the age of the stamp
// is used, limited to 1 s, because the wall clock may have been set in between.
Time stamped_at(Duration stamp, Duration wall, Time now);

class DeviceClock {
 public:
  // `tick`: period of the counter, which wraps to 0 after `ticks_of_turn` ticks.
  DeviceClock(Duration tick, std::uint64_t ticks_of_turn)
      : tick_(tick), ticks_of_turn_(ticks_of_turn) {}

  // The host time at which the counter had this value; never later than `arrival`, the time at
  // which the message was received. A counter that jumps back means that the device was restarted.
  Time to_host(std::uint64_t counter, Time arrival);
  void reset();

 private:
  struct Window {
    Time begin{};
    std::optional<std::int64_t> least;  // arrival minus counter, ns
  };

  static constexpr Duration kWindow = std::chrono::seconds(5);

  Duration tick_;
  std::uint64_t ticks_of_turn_;
  std::optional<std::uint64_t> last_;
  std::uint64_t turns_ = 0;
  Window now_;
  Window before_;
};

// The same for a device without a counter that sends after each turn of its mirror, or after some
// of them: the turns are the clock. A message that arrives earlier than a whole number of turns
// after the last one shows that the last one was delayed, and sets the clock. A message that
// arrives later is delayed, or the mirror is slower than nominal, by at most 0.5 %.
class TurnClock {
 public:
  explicit TurnClock(Duration turn) : turn_(turn) {}

  // When the message would have arrived without delay: never later than `arrival`.
  Time to_host(Time arrival);
  void reset() { last_.reset(); }

 private:
  Duration turn_;
  std::optional<Time> last_{};
};

}  // namespace rack::device

#pragma GCC visibility pop

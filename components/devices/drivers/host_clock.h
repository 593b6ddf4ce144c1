// The clock of this host, set by a device that knows the time: realtimeClockUpdate.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

// What is to be done about a clock that is `ahead` of the device's time by so much.
enum class ClockChange : std::uint8_t { kSlowly, kAtOnce, kRefused };

// Back by more than a day it is the device that errs: receivers whose count of weeks has begun anew
// are 19 years behind, and what is emulated may be of any day.
constexpr ClockChange clock_change(tims::Duration ahead) {
  if (ahead > std::chrono::hours(24)) return ClockChange::kRefused;
  const bool is_near = std::chrono::abs(ahead) < std::chrono::milliseconds(100);
  return is_near ? ClockChange::kSlowly : ClockChange::kAtOnce;
}

class HostClock {
 public:
  void start(bool is_wanted, std::chrono::milliseconds interval) {
    is_wanted_ = is_wanted;
    interval_ = interval;
    updated_.reset();
  }

  // It was `utc` (since 1970) at `measured`. True: the clock was set, so that time stamps from
  // before are of another time. Small differences are made up for slowly, without a jump. An error
  // comes once: without CAP_SYS_TIME, or with a device of another time, there is no use in trying
  // again.
  tims::Result<bool> update(tims::Duration utc, tims::Time measured, tims::Time now);

 private:
  bool is_wanted_ = false;
  std::chrono::milliseconds interval_{};
  std::optional<tims::Time> updated_;
};

}  // namespace rack::device

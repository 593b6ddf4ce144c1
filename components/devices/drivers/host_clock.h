// Sets the clock of this host from a device with a time source: parameter realtimeClockUpdate.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

// How to correct a clock.
enum class ClockChange : std::uint8_t { kSlowly, kAtOnce, kRefused, kUnconfirmed };

// `ahead`: host clock minus device time. If setting it back by more than a day were required, the
// device is assumed to be wrong: after a rollover of the GPS week number, receivers are 19 years
// behind, and emulated devices may report any day.
constexpr ClockChange clock_change(tims::Duration ahead) {
  if (ahead > std::chrono::hours(24)) return ClockChange::kRefused;
  const bool is_near = std::chrono::abs(ahead) < std::chrono::milliseconds(100);
  return is_near ? ClockChange::kSlowly : ClockChange::kAtOnce;
}

// Decides for each time that a device reports. A single wrong date, as receivers send after a cold
// start, neither sets the clock nor ends its setting: a step of more than a day is made only if the
// device has reported the same difference for some seconds.
class ClockDecision {
 public:
  static constexpr tims::Duration kConfirmedAfter = std::chrono::seconds(10);

  ClockChange decide(tims::Duration ahead, tims::Time now);
  // True for the first refusal after an accepted time.
  [[nodiscard]] bool is_first_refusal() const { return refusals_ == 1; }

 private:
  struct Step {
    tims::Duration ahead{};
    tims::Time since{};
  };
  std::optional<Step> unconfirmed_;
  std::uint64_t refusals_ = 0;
};

class HostClock {
 public:
  void start(bool is_wanted, std::chrono::milliseconds interval) {
    is_wanted_ = is_wanted;
    interval_ = interval;
    updated_.reset();
    decision_ = {};
  }

  // The device reported `utc` (since 1970) for time `measured`. Returns true if the clock was set
  // in one step, which invalidates earlier time stamps. Small differences are corrected gradually.
  // An error is returned once only. Without CAP_SYS_TIME, further attempts would fail too; a wrong
  // time of the device is ignored until it is right.
  tims::Result<bool> update(tims::Duration utc, tims::Time measured, tims::Time now);

 private:
  bool is_wanted_ = false;
  std::chrono::milliseconds interval_{};
  std::optional<tims::Time> updated_;
  ClockDecision decision_;
};

}  // namespace rack::device

#include "components/devices/drivers/host_clock.h"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <string>

#include <sys/time.h>

namespace rack::device {
namespace {

using tims::Duration;

Duration wall_clock() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return std::chrono::seconds(now.tv_sec) + Duration(now.tv_nsec);
}

bool slew(Duration difference) {
  const auto microseconds = std::chrono::duration_cast<std::chrono::microseconds>(difference);
  timeval delta{.tv_sec = 0, .tv_usec = microseconds.count()};
  return ::adjtime(&delta, nullptr) == 0;
}

bool step(Duration time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  const timespec now{.tv_sec = seconds.count(), .tv_nsec = (time - seconds).count()};
  return ::clock_settime(CLOCK_REALTIME, &now) == 0;
}

}  // namespace

ClockChange ClockDecision::decide(Duration ahead, tims::Time now) {
  constexpr Duration kDay = std::chrono::hours(24);
  constexpr Duration kTolerance = std::chrono::seconds(1);
  const ClockChange change = clock_change(ahead);
  refusals_ = change == ClockChange::kRefused ? refusals_ + 1 : 0;
  if (change != ClockChange::kAtOnce || std::chrono::abs(ahead) <= kDay) {
    unconfirmed_.reset();
    return change;
  }
  if (!unconfirmed_ || std::chrono::abs(unconfirmed_->ahead - ahead) > kTolerance)
    unconfirmed_ = {.ahead = ahead, .since = now};
  return now - unconfirmed_->since < kConfirmedAfter ? ClockChange::kUnconfirmed : change;
}

tims::Result<bool> HostClock::update(Duration utc, tims::Time measured, tims::Time now) {
  if (!is_wanted_ || (updated_ && now - *updated_ < interval_)) return false;
  const Duration time = utc + (now - measured);
  const Duration ahead = wall_clock() - time;
  const ClockChange change = decision_.decide(ahead, now);
  if (change == ClockChange::kUnconfirmed) return false;
  if (change == ClockChange::kRefused) {
    if (!decision_.is_first_refusal()) return false;
    const auto days = std::chrono::duration_cast<std::chrono::days>(ahead).count();
    return tims::Error(
        tims::Errc::kInvalidArgument,
        "the device's time is " + std::to_string(days) +
            " days behind this host's: the clock is not set back by more than a "
            "day; it is set when the device's date is right (check that of this host, "
            "too)");
  }
  const bool is_slow = change == ClockChange::kSlowly;
  if (!(is_slow ? slew(-ahead) : step(time))) {
    is_wanted_ = false;
    return tims::Error(tims::Errc::kSystem,
                       std::string("cannot set the time of this host: ") + std::strerror(errno) +
                           "; grant CAP_SYS_TIME, or set realtimeClockUpdate=0");
  }
  updated_ = now;
  return !is_slow;
}

}  // namespace rack::device

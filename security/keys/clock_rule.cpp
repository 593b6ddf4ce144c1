#include "security/keys/clock_rule.h"

#include <chrono>

#include <sys/timex.h>

namespace tims::security {

CheckTime system_check_time(std::int64_t passed) {
  timex state{};
  const bool synchronised = ::adjtimex(&state) >= 0 && (state.status & STA_UNSYNC) == 0;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return check_time({.system = std::chrono::duration_cast<std::chrono::seconds>(now).count(),
                     .synchronised = synchronised,
                     .passed = passed});
}

}  // namespace tims::security

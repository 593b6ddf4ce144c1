#include "tools/evaluation/drives/machine.h"

#include <utility>

#include "tims/time.h"

namespace rack::drives {

void Machine::advance(tims::Time now, tims::Duration step) {
  const double seconds = std::chrono::duration<double>(step).count();
  const auto happens = [&](double per_second) {
    return static_cast<double>(random_.uniform()) < per_second * seconds;
  };
  for (tims::Time& until : waits_until_) {
    if (until > now || !happens(load_.stalls_per_second)) continue;
    const double share = random_.uniform();
    until = now + std::chrono::duration_cast<tims::Duration>(share * load_.longest_stall);
  }
  if (!happens(load_.crashes_per_minute / 60)) return;
  const std::size_t program = random_.below(kPrograms);
  has_crashed_.at(program) = true;
  waits_until_.at(program) = now + load_.restart;
}

bool Machine::take_crash(Program program) {
  return std::exchange(has_crashed_.at(index(program)), false);
}

}  // namespace rack::drives

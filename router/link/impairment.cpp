#include "router/link/impairment.h"

#include <algorithm>

#include "router/core/random.h"
#include "router/link/train.h"

namespace tims::link {

double Impairment::random() { return core::next_share(state_); }

Time Impairment::arrival(Time sent) {
  Time at = sent + faults_.delay;
  if (faults_.jitter > Duration::zero())
    at +=
        Duration(static_cast<std::int64_t>(random() * static_cast<double>(faults_.jitter.count())));
  last_ = std::max(last_, at);
  return last_;
}

Impairment::Fate Impairment::send(Time now, std::size_t size) {
  Fate fate;
  if (faults_.blackout || (faults_.mtu != 0 && size > faults_.mtu)) return fate;
  if (random() < faults_.loss) return fate;
  Time sent = now;
  if (faults_.rate != 0) {
    const auto rate = static_cast<double>(faults_.rate);
    const double waiting =
        std::chrono::duration<double>(std::max(line_free_, now) - now).count() * rate;
    if (waiting > static_cast<double>(faults_.queue)) return fate;
    const Duration takes = std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>(static_cast<double>(size + kDatagramOverhead) / rate));
    line_free_ = std::max(line_free_, now) + takes;
    sent = line_free_;
  }
  fate.at[fate.count++] =
      random() < faults_.reorder ? sent + faults_.delay + faults_.held_back : arrival(sent);
  if (random() < faults_.duplicate) fate.at[fate.count++] = arrival(sent);
  return fate;
}

}  // namespace tims::link

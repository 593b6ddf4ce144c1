#include "router/link/fault_injection.h"

#include <algorithm>

#include "router/core/random.h"
#include "router/link/transport.h"

namespace tims::link {

double FaultInjector::random() { return core::next_share(state_); }

Time FaultInjector::arrival(Time sent) {
  Time at = sent + faults_.delay;
  if (faults_.jitter > Duration::zero())
    at +=
        Duration(static_cast<std::int64_t>(random() * static_cast<double>(faults_.jitter.count())));
  last_ = std::max(last_, at);
  return last_;
}

FaultInjector::Copies FaultInjector::send(Time now, std::size_t size) {
  Copies copies;
  if (faults_.blackout || (faults_.mtu != 0 && size > faults_.mtu)) return copies;
  if (random() < faults_.loss) return copies;
  Time sent = now;
  if (faults_.rate != 0) {
    const auto rate = static_cast<double>(faults_.rate);
    const double waiting =
        std::chrono::duration<double>(std::max(line_free_, now) - now).count() * rate;
    if (waiting > static_cast<double>(faults_.queue)) return copies;
    const Duration takes = std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>(static_cast<double>(size + kDatagramOverhead) / rate));
    line_free_ = std::max(line_free_, now) + takes;
    sent = line_free_;
  }
  copies.at[copies.count++] =
      random() < faults_.reorder ? sent + faults_.delay + faults_.held_back : arrival(sent);
  if (random() < faults_.duplicate) copies.at[copies.count++] = arrival(sent);
  return copies;
}

}  // namespace tims::link

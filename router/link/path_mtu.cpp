#include "router/link/path_mtu.h"

namespace tims::link {

std::size_t PathMtu::probe(Time now, std::size_t most) const {
  return now >= next_probe(most) ? kSteps[step_] : 0;
}

void PathMtu::on_probe_sent(std::size_t) { probing_ = true; }

void PathMtu::on_probe_acked(Time now, std::size_t size) {
  probing_ = false;
  tries_ = 0;
  lost_in_a_row_ = 0;
  if (size > size_) size_ = size;
  while (step_ < kSteps.size() && kSteps[step_] <= size_) ++step_;
  next_ = step_ < kSteps.size() ? now + kBetween : kNever;
}

void PathMtu::on_probe_lost(Time now) {
  probing_ = false;
  next_ = now + kBetween;
  if (++tries_ < kTries) return;
  // Larger ones would fare no better. Later, perhaps.
  tries_ = 0;
  next_ = now + kTryAgain;
}

void PathMtu::on_acked(std::size_t datagram) {
  if (datagram > kDatagramBase) lost_in_a_row_ = 0;
}

bool PathMtu::on_lost(Time now, std::size_t datagram) {
  if (datagram <= kDatagramBase || size_ == kDatagramBase || fixed_) return false;
  if (++lost_in_a_row_ < kBlackHole) return false;
  reset(now);
  return true;
}

void PathMtu::fix(std::size_t size) {
  *this = PathMtu();
  size_ = size;
  step_ = kSteps.size();
  fixed_ = true;
}

void PathMtu::reset(Time now) {
  *this = PathMtu();
  next_ = now + kBetween;
}

}  // namespace tims::link

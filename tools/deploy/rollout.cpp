#include "tools/deploy/rollout.h"

#include <algorithm>

namespace timsctl::deploy {

Rollout::Rollout(std::vector<std::string> names, bool undo)
    : names_(std::move(names)), hosts_(names_.size(), HostRun(undo)) {}

std::vector<std::size_t> Rollout::settle() {
  std::vector<std::size_t> ended;
  if (gone_) return ended;
  const auto failed =
      std::ranges::find_if(hosts_, [](const HostRun& host) { return host.end() != End::kNone; });
  if (failed == hosts_.end()) return ended;
  const std::string reason =
      names_[static_cast<std::size_t>(failed - hosts_.begin())] + " could not be prepared";
  for (std::size_t i = 0; i < hosts_.size(); ++i)
    if (hosts_[i].end() == End::kNone) {
      hosts_[i].cancel(reason);
      ended.push_back(i);
    }
  return ended;
}

bool Rollout::is_ready() const { return !gone_ && std::ranges::all_of(hosts_, &HostRun::is_ready); }

void Rollout::go() {
  gone_ = true;
  for (HostRun& host : hosts_) host.go();
}

void Rollout::cancel(const std::string& reason) {
  gone_ = true;
  for (HostRun& host : hosts_) host.cancel(reason);
}

void Rollout::stop() {
  gone_ = true;
  for (HostRun& host : hosts_) host.stop();
}

bool Rollout::is_over() const { return std::ranges::all_of(hosts_, &HostRun::is_over); }

tims::Time Rollout::next_begin() const {
  tims::Time next = tims::kNever;
  for (const HostRun& host : hosts_) next = std::min(next, host.next_begin());
  return next;
}

bool Rollout::succeeded() const {
  return std::ranges::all_of(hosts_, [](const HostRun& host) {
    return host.end() == End::kKept || host.end() == End::kSame;
  });
}

}  // namespace timsctl::deploy

#include "tools/deploy/host_run.h"

#include <algorithm>
#include <array>

namespace timsctl::deploy {

std::string_view name_of(Step step) {
  constexpr std::array<std::string_view, 11> kNames{
      "connecting",       "looking",     "recovering", "sending files",
      "sending packages", "preparing",   "ready",      "stopping",
      "applying",         "cleaning up", "over"};
  return kNames[static_cast<std::size_t>(step)];
}

std::string_view name_of(End end) {
  constexpr std::array<std::string_view, 7> kNames{"",       "deployed",  "unchanged", "went_back",
                                                   "broken", "untouched", "unknown"};
  return kNames[static_cast<std::size_t>(end)];
}

std::optional<Step> HostRun::begin(tims::Time now) {
  if (running_ || is_over() || now < not_before_ || (is_ready() && connected_)) return std::nullopt;
  running_ = true;
  begun_ = connected_ ? step_ : Step::kConnect;
  if (begun_ == Step::kStage) holds_ = true;
  if (begun_ == Step::kApply) ++applies_begun_;
  return begun_;
}

tims::Time HostRun::next_begin() const {
  return running_ || is_over() || (is_ready() && connected_) ? tims::kNever : not_before_;
}

void HostRun::done() {
  running_ = false;
  if (begun_ == Step::kConnect) {
    connected_ = was_connected_ = true;
    return;
  }
  lost_at_.reset();
  pause_ = kFirstPause;
  switch (step_) {
    case Step::kStage:
      step_ = undo_ ? Step::kReady : packages_ > 0 ? Step::kCarry : Step::kPrepare;
      break;
    case Step::kCarry:
      if (++sent_ >= packages_) step_ = Step::kPrepare;
      break;
    case Step::kPrepare:
      step_ = Step::kReady;
      break;
    case Step::kStop:
      step_ = Step::kApply;
      break;
    default:  // kRelease; the others end by functions of their own
      step_ = Step::kOver;
      break;
  }
}

void HostRun::looked(bool interrupted, std::size_t packages) {
  packages_ = packages;
  done();
  step_ = interrupted ? Step::kRecover : Step::kStage;
}

void HostRun::applied(End end, std::string reason) {
  const bool recovers = step_ == Step::kRecover;
  running_ = false;
  lost_at_.reset();
  if (recovers && end != End::kBroken) {
    step_ = Step::kLook;
    return;
  }
  end_ = end;
  reason_ = std::move(reason);
  step_ = Step::kOver;
}

void HostRun::lost(tims::Time now, const std::string& reason) {
  running_ = false;
  connected_ = false;
  if (!was_connected_) return finish(End::kUntouched, reason);
  if (!lost_at_) lost_at_ = now;
  if (now - *lost_at_ >= (applies() ? kGiveUpApplying : kGiveUp)) {
    holds_ = false;  // it cannot be told
    return finish(applies() ? End::kUnknown : End::kUntouched, reason);
  }
  not_before_ = now + pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
}

void HostRun::failed(const std::string& reason) {
  running_ = false;
  if (step_ == Step::kRelease || step_ == Step::kOver) {
    step_ = Step::kOver;
    return;
  }
  if (step_ == Step::kStop) {
    step_ = Step::kApply;  // which tells how it has ended
    return;
  }
  finish(applies_begun_ > 1 ? End::kUnknown : End::kUntouched, reason);
}

void HostRun::finish(End end, const std::string& reason) {
  if (end_ == End::kNone) {
    end_ = end;
    reason_ = reason;
  }
  running_ = false;
  step_ =
      holds_ && end_ == End::kUntouched && step_ != Step::kRelease ? Step::kRelease : Step::kOver;
}

void HostRun::go() {
  if (is_ready()) step_ = Step::kApply;
}

void HostRun::cancel(const std::string& reason) {
  if (!applies() && end_ == End::kNone) finish(End::kUntouched, reason);
}

void HostRun::stop() {
  cancel("stopped");
  running_ = false;
  if (applies()) step_ = Step::kStop;
}

}  // namespace timsctl::deploy

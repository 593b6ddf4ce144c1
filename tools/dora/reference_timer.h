// How late a timer of the highest priority wakes on this machine, meanwhile: by cyclictest, where
// it is installed and may do so, else by a loop of the same kind.
#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "components/runtime/thread.h"
#include "tools/cli/service.h"
#include "tools/dora/judgement.h"

namespace rack::dora {

class ReferenceTimer {
 public:
  ReferenceTimer();
  ~ReferenceTimer();
  ReferenceTimer(const ReferenceTimer&) = delete;
  ReferenceTimer& operator=(const ReferenceTimer&) = delete;

  // Ends it; what it has found.
  TimerQuality end();

 private:
  void measure();

  std::string log_;
  std::optional<timsctl::Process> cyclictest_;
  std::atomic<bool> ending_ = false;
  bool real_time_ = false;
  WakeupHistogram histogram_;
  Thread thread_;
};

}  // namespace rack::dora

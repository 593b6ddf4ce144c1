// What this machine does without a robot, meanwhile: no robot on it is better.
//
// ReferenceTimer: how late a timer of the highest priority wakes, by cyclictest, where it is
// installed and may do so, else by a loop of the same kind. ReferenceTerminal: how evenly a byte
// that is written 75 times a second comes out of a terminal; one thread writes, one reads, both of
// a real-time priority, and nothing is between them but the kernel.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "components/runtime/thread.h"
#include "os/file.h"
#include "tools/cli/service.h"
#include "tools/evaluation/dora/judgement.h"

namespace rack::dora {

// With that priority, or without one where there is no right to it: false. Throws timsctl::Failure.
bool start_thread(Thread& thread, const std::string& name, int priority,
                  const std::function<void()>& body);

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

class ReferenceTerminal {
 public:
  // Throws timsctl::Failure.
  ReferenceTerminal();
  ~ReferenceTerminal();
  ReferenceTerminal(const ReferenceTerminal&) = delete;
  ReferenceTerminal& operator=(const ReferenceTerminal&) = delete;

  // Ends it; by how much the gaps between two bytes were longer or shorter.
  TimerQuality end();

 private:
  void write();
  void read();

  tims::os::File device_;  // what a device is plugged into
  tims::os::File line_;    // what a driver opens
  std::atomic<bool> ending_ = false;
  bool real_time_ = false;
  WakeupHistogram histogram_;
  Thread writer_;
  Thread reader_;
};

}  // namespace rack::dora

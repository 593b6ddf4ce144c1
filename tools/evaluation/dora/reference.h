// Measures the timing of this machine during the run: a lower bound for any robot on it.
//
// ReferenceTimer measures the wake-up latency of a timer of high priority with cyclictest, or with
// an equivalent loop if cyclictest is not installed or not permitted. ReferenceTerminal measures
// the jitter of a byte that is written 75 times a second to a pseudo-terminal: one thread writes
// and one reads, both with a real-time priority, with only the kernel in between.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "os/file.h"
#include "rack/thread.h"
#include "tools/cli/service.h"
#include "tools/evaluation/dora/judgement.h"

namespace rack::dora {

// Starts the thread with this priority; returns false if that is not permitted and the thread has
// started without it. Throws timsctl::Failure.
bool start_thread(Thread& thread, const std::string& name, int priority,
                  const std::function<void()>& body);

class ReferenceTimer {
 public:
  ReferenceTimer();
  ~ReferenceTimer();
  ReferenceTimer(const ReferenceTimer&) = delete;
  ReferenceTimer& operator=(const ReferenceTimer&) = delete;

  // Stops the measurement and returns its result.
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

  // Stops the measurement and returns the deviation of the intervals between two bytes.
  TimerQuality end();

 private:
  void write();
  void read();

  tims::os::File device_;  // the end of the device
  tims::os::File line_;    // the end that a driver opens
  std::atomic<bool> ending_ = false;
  bool real_time_ = false;
  WakeupHistogram histogram_;
  Thread writer_;
  Thread reader_;
};

}  // namespace rack::dora

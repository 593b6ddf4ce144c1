// How evenly a byte that is written 75 times a second comes out of a terminal of this machine,
// meanwhile: one thread writes, one reads, both of a real-time priority, and nothing is between
// them but the kernel. No driver behind a serial line is evener.
#pragma once

#include <atomic>

#include "components/runtime/thread.h"
#include "os/file.h"
#include "tools/dora/judgement.h"

namespace rack::dora {

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

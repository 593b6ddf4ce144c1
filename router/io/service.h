// The process as a service: signals, the service manager, limits, memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include "os/environment.h"
#include "os/file.h"
#include "router/io/loop.h"
#include "tims/result.h"

namespace tims::io {

// SIGTERM, SIGINT and SIGHUP come as calls from the loop.
class Signals {
 public:
  struct Actions {
    std::function<void()> stop;
    std::function<void()> reload;
  };
  Signals(Loop& loop, Actions actions);

 private:
  void take();

  Actions actions_;
  os::File file_;
  Watch watch_;
};

// The service manager is kept informed, and its watchdog fed.
class Service {
 public:
  explicit Service(Loop& loop);

  // The watchdog, when the unit has one, is fed from here on.
  void ready();
  void reloading();
  void stopping();

 private:
  void feed();

  os::ServiceManager manager_;
  std::chrono::microseconds interval_{};  // 0: no watchdog
  Timer timer_;
};

// SCHED_FIFO for the thread that calls, and no other that it starts; memory of this process is kept
// in RAM as far as it is touched. The error says what is missing; what is allowed is done.
Result<void> become_real_time(int priority);

// Of the process, in RAM.
std::uint64_t resident_bytes();

// As many file descriptors as the system lets this process have.
void raise_descriptor_limit();

}  // namespace tims::io

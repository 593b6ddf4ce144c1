// The process as a service: signals, the service manager, limits.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "os/file.h"
#include "router/io/timer.h"
#include "router/io/watch.h"
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

// What systemd wants to hear, as datagrams to $NOTIFY_SOCKET (sd_notify(3)); nothing without it.
class ServiceManager {
 public:
  explicit ServiceManager(Loop& loop);

  // The watchdog, when the unit has one, is fed from here on.
  void ready();
  void reloading();
  void stopping();

 private:
  void notify(std::string_view text) const;
  void feed();

  std::string path_;
  std::chrono::microseconds interval_{};  // 0: no watchdog
  Timer timer_;
};

// As many file descriptors as the system lets this process have.
void raise_descriptor_limit();

}  // namespace tims::io

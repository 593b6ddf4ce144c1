// The process as a service: signals, service manager, limits, memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include <boost/asio/signal_set.hpp>

#include "os/service_manager.h"
#include "os/socket_store.h"
#include "router/io/loop.h"
#include "tims/result.h"

namespace tims::io {

// Delivers SIGTERM, SIGINT, SIGHUP and SIGUSR2 as calls from the loop. Must exist until the loop
// has ended.
class Signals {
 public:
  struct Actions {
    std::function<void()> stop;
    std::function<void()> reload;
    std::function<void()> hand_over;  // SIGUSR2: another run of this program follows at once
  };
  Signals(Loop& loop, Actions actions);
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

 private:
  void wait();

  Actions actions_;
  boost::asio::signal_set signals_;
};

// Notifies the service manager and triggers its watchdog.
class Service {
 public:
  explicit Service(Loop& loop);

  // From here on the watchdog is triggered, if the unit has one.
  void ready();
  void reloading();
  void stopping();

  // Sockets that outlive this process.
  os::SocketStore& sockets() { return sockets_; }

 private:
  void feed();
  void wait(bool reported);

  os::ServiceManager manager_;
  os::SocketStore sockets_{manager_, os::SocketStore::inherited()};
  std::chrono::microseconds interval_{};  // 0: no watchdog
  Timer timer_;
};

// Sets SCHED_FIFO for the calling thread only, not inherited by threads it starts, and locks
// touched memory of the process. Does what is permitted; the error names what is missing.
Result<void> become_real_time(int priority);

// Resident memory of the process.
std::uint64_t resident_bytes();

// Raises the limit of file descriptors to the maximum permitted.
void raise_descriptor_limit();

}  // namespace tims::io

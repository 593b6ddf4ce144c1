// A thread with a name and, when wanted, a real-time priority, and a CPU of its own.
#pragma once

#include <functional>
#include <string>

#include <pthread.h>

#include "tims/result.h"

namespace rack {

// From here on SCHED_FIFO. 1 is the original's default: nothing special.
inline constexpr int kFirstRealTime = 2;

// Bound to one, it waits for others there while a second stands idle. The original binds to 0.
inline constexpr int kAnyCpu = -1;

struct ThreadSettings {
  std::string name{};  // at most 15 characters are kept
  int priority = 0;    // up to 99; below kFirstRealTime: an ordinary thread
  int cpu = kAnyCpu;   // of real-time threads; one that does not exist: 0
};

class Thread {
 public:
  Thread() = default;
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;
  ~Thread() { join(); }

  // kSystem when the priority is not allowed; the text says what would allow it.
  tims::Result<void> start(const ThreadSettings& settings, std::function<void()> body);
  void join();

 private:
  static void* run(void* self);

  std::function<void()> body_;
  pthread_t id_{};
  bool running_ = false;
};

// Keeps all memory of this process in RAM. What it has now never faults again; what comes later
// faults when it is touched first.
tims::Result<void> lock_memory();

}  // namespace rack

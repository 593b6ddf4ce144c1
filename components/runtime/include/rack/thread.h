// A thread with a name and optionally a real-time priority and a fixed CPU.
#pragma once

#include <functional>
#include <string>

#include <pthread.h>

#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

// From this priority on SCHED_FIFO. 1 is the default of the original: an ordinary thread.
inline constexpr int kFirstRealTime = 2;

// A thread bound to one CPU may wait there while another CPU is idle. The original binds to CPU 0.
inline constexpr int kAnyCpu = -1;

struct ThreadSettings {
  std::string name{};  // at most 15 characters are kept
  int priority = 0;    // up to 99; below kFirstRealTime: an ordinary thread
  int cpu = kAnyCpu;   // of real-time threads; 0 if the CPU does not exist
};

class Thread {
 public:
  Thread() = default;
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;
  ~Thread() { join(); }

  // kSystem: the priority is not permitted; the text names the capability that is needed.
  tims::Result<void> start(const ThreadSettings& settings, std::function<void()> body);
  void join();

 private:
  static void* run(void* self);

  std::function<void()> body_;
  pthread_t id_{};
  bool running_ = false;
};

// Locks all memory of this process in RAM. Current memory never faults again; memory mapped later
// faults at its first access.
tims::Result<void> lock_memory();

}  // namespace rack

#pragma GCC visibility pop

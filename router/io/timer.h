// Calls its owner once when a time has come.
#pragma once

#include <functional>

#include "router/io/loop.h"

namespace tims::io {

class Timer {
 public:
  // The owner may destroy the timer when it is called.
  Timer(Loop& loop, std::function<void()> on_timeout);
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  ~Timer();

  // Instead of what it was set to before.
  void set(Time at);
  void cancel() { set(kNever); }

 private:
  friend Loop;
  Loop& loop_;
  std::function<void()> on_timeout_;
  Time at_ = kNever;
};

}  // namespace tims::io

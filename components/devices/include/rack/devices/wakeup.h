// Wakes a thread that waits for a device: Device::wait(until, wakeup.descriptor()) returns after
// signal(), which any thread may call.
#pragma once

#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

class Wakeup {
 public:
  Wakeup() = default;
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;
  ~Wakeup();

  // Until then signal() has no effect. kSystem: no descriptors are left.
  tims::Result<void> open();
  // Never waits. Several calls before drain() wake once.
  void signal() const;
  void drain() const;
  // Readable from signal() to drain(); -1 before open().
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
};

}  // namespace rack::device

#pragma GCC visibility pop

// Tells when addresses, carrier or routes of this host change.
#pragma once

#include <functional>
#include <optional>

#include "os/file.h"
#include "router/io/net/debounce.h"
#include "router/io/timer.h"
#include "router/io/watch.h"
#include "tims/result.h"

namespace tims::io {

class InterfaceWatch {
 public:
  // Called once for changes close together (Debounce), from the loop. There may have been none that
  // matters, as when a router renews an address: whoever's reaction is costly compares.
  InterfaceWatch(Loop& loop, std::function<void()> on_change);

  // From here on; once.
  Result<void> start();

 private:
  bool take();
  void put_off();
  void on_timer();

  Loop& loop_;
  std::function<void()> on_change_;
  os::File file_;
  std::optional<Watch> watch_;
  Timer timer_;
  Debounce debounce_;
};

}  // namespace tims::io

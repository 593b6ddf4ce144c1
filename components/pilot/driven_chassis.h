// The chassis that a pilot drives.
#pragma once

#include <optional>

#include "rack/proxies/chassis.h"

namespace rack::pilot {

class DrivenChassis {
 public:
  // Turns it on; returns what it can do.
  Result<ChassisParamData> take(tims::Mailbox& work, tims::Address chassis) {
    proxy_.emplace(work, chassis);
    if (const auto on = proxy_->on(); !on) return on.error();
    return proxy_->get_parameter();
  }
  // Stops it, also when it was never taken.
  void let_go() {
    if (proxy_) (void)proxy_->move(0, 0, 0);
  }
  ChassisProxy* operator->() { return &*proxy_; }

 private:
  std::optional<ChassisProxy> proxy_;
};

}  // namespace rack::pilot

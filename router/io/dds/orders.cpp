#include "router/io/dds/orders.h"

#include "os/clock.h"

namespace tims::io {
namespace {

// The same clock, by the name the standard library waits with.
std::chrono::steady_clock::time_point steady(Time time) {
  return std::chrono::steady_clock::time_point(time.time_since_epoch());
}

}  // namespace

DdsOrders::Wanted DdsOrders::wait() {
  std::unique_lock lock(mutex_);
  change_.wait(lock, [this] { return changed_; });
  changed_ = false;
  return wanted_;
}

void DdsOrders::ended() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  end_.notify_all();
}

bool DdsOrders::wait_for_end(Duration limit) {
  std::unique_lock lock(mutex_);
  return end_.wait_until(lock, steady(os::now() + limit), [this] { return ended_; });
}

}  // namespace tims::io

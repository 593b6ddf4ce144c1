#include "router/io/dds/orders.h"

#include <utility>

#include "os/clock.h"

namespace tims::io {
namespace {

// The same clock, by the name the standard library waits with.
std::chrono::steady_clock::time_point steady(Time time) {
  return std::chrono::steady_clock::time_point(time.time_since_epoch());
}

}  // namespace

bool DdsOrders::wait(Time until, Wanted& wanted) {
  std::unique_lock lock(mutex_);
  const auto stirred = [this] { return stirred_; };
  if (until == kNever) {
    wake_.wait(lock, stirred);
  } else {
    wake_.wait_until(lock, steady(until), stirred);
  }
  stirred_ = false;
  if (!std::exchange(changed_, false)) return false;
  wanted = wanted_;
  return true;
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

#include "router/io/dds/events.h"

#include <utility>

#include "os/clock.h"

namespace tims::io {
namespace {

// The same clock, as the type used by the standard library for waiting.
std::chrono::steady_clock::time_point steady(Time time) {
  return std::chrono::steady_clock::time_point(time.time_since_epoch());
}

}  // namespace

Result<std::shared_ptr<DdsEvents>> DdsEvents::make() {
  auto wake_fd = os::make_event_fd();
  if (!wake_fd) return wake_fd.error();
  return std::make_shared<DdsEvents>(std::move(*wake_fd));
}

// Once until the loop has read it, because samples arrive faster than the loop turns.
void DdsEvents::notify() {
  if (!notified_.exchange(true)) os::signal_event_fd(wake_fd_.get());
}

DdsEvents::All DdsEvents::take() {
  os::drain_event_fd(wake_fd_.get());
  notified_ = false;  // before reading any state
  const std::lock_guard lock(mutex_);
  return std::exchange(all_, {});
}

template <typename Change>
void DdsEvents::post(Change change) {
  {
    const std::lock_guard lock(mutex_);
    change(all_);
  }
  notify();
}

void DdsEvents::post_up(Up up) {
  post([&](All& all) { all.up = std::move(up); });
}
void DdsEvents::post_failure(Failure failure) {
  post([&](All& all) { all.failure = std::move(failure); });
}
void DdsEvents::post_router(const link::DdsParticipant& participant, Router router) {
  post([&](All& all) { all.routers[participant] = std::move(router); });
}
void DdsEvents::post_writer(WriterReady ready) {
  post([&](All& all) { all.writers.push_back(std::move(ready)); });
}

void DdsEvents::post_line(Line line) {
  {
    const std::lock_guard lock(mutex_);
    if (!lines_limiter_.take(os::now())) return;
    if (const auto n = lines_limiter_.take_held_back(); n > 0)
      all_.lines.push_back({false, std::to_string(n) + " more lines suppressed"});
    all_.lines.push_back(std::move(line));
  }
  notify();
}

DdsCommands::Wanted DdsCommands::wait() {
  std::unique_lock lock(mutex_);
  change_.wait(lock, [this] { return changed_; });
  changed_ = false;
  return wanted_;
}

void DdsCommands::ended() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  end_.notify_all();
}

bool DdsCommands::wait_for_end(Duration limit) {
  std::unique_lock lock(mutex_);
  return end_.wait_until(lock, steady(os::now() + limit), [this] { return ended_; });
}

}  // namespace tims::io

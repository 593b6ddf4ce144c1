#include "router/io/dds/news.h"

#include <utility>

#include "os/clock.h"

namespace tims::io {
namespace {

constexpr unsigned kLinesMax = 10;
constexpr Duration kLinesWindow = std::chrono::seconds(10);

}  // namespace

Result<std::shared_ptr<DdsNews>> DdsNews::make() {
  auto bell = os::make_event_fd();
  if (!bell) return bell.error();
  return std::make_shared<DdsNews>(std::move(*bell));
}

// Once until it is heard: samples come faster than the loop turns.
void DdsNews::ring() {
  if (!rung_.exchange(true)) os::signal_event_fd(bell_.get());
}

DdsNews::All DdsNews::take() {
  os::drain_event_fd(bell_.get());
  rung_ = false;  // before anything is looked at
  const std::lock_guard lock(mutex_);
  return std::exchange(all_, {});
}

void DdsNews::is_up(const Up& up) {
  {
    const std::lock_guard lock(mutex_);
    all_.up = up;
  }
  ring();
}

void DdsNews::has_failed(Failure failure) {
  {
    const std::lock_guard lock(mutex_);
    all_.failure = std::move(failure);
  }
  ring();
}

void DdsNews::has_seen(const link::DdsParticipant& participant, Router router) {
  {
    const std::lock_guard lock(mutex_);
    all_.routers[participant] = std::move(router);
  }
  ring();
}

void DdsNews::has_opened(Opened opened) {
  {
    const std::lock_guard lock(mutex_);
    all_.opened.push_back(std::move(opened));
  }
  ring();
}

void DdsNews::has_said(Line line) {
  {
    const std::lock_guard lock(mutex_);
    if (!may_pass(os::now())) return;
    all_.lines.push_back(std::move(line));
  }
  ring();
}

bool DdsNews::may_pass(Time now) {
  if (now - lines_since_ >= kLinesWindow) {
    if (lines_held_back_ > 0)
      all_.lines.push_back({false, std::to_string(lines_held_back_) + " more lines held back"});
    lines_since_ = now;
    lines_passed_ = lines_held_back_ = 0;
  }
  if (lines_passed_ == kLinesMax) {
    ++lines_held_back_;
    return false;
  }
  ++lines_passed_;
  return true;
}

}  // namespace tims::io

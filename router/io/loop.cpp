#include "router/io/loop.h"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <sys/timerfd.h>

#include "os/clock.h"

namespace tims::io {

Loop::Loop()
    : epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      alarm_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {
  // Edge-triggered: setting the alarm again cancels a pending event, so it need not be read.
  epoll_event event{.events = EPOLLIN | EPOLLET, .data = {.ptr = this}};
  if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, alarm_.get(), &event) != 0)
    throw std::system_error(errno, std::generic_category(), "no event loop: epoll, timerfd");
}

void Loop::end_turn(Time began) {
  for (const auto& step : steps_) step(began);
  longest_turn_ = std::max(longest_turn_, os::now() - began);
}

void Loop::run() {
  while (!stopped_) run_once(kNever);
}

void Loop::run_once(Time limit) {
  arm(std::min(next_deadline(), limit));
  const int n = ::epoll_wait(epoll_.get(), events_.data(), kEventsMax, posted_.empty() ? -1 : 0);
  hand_out(std::span(events_).first(static_cast<std::size_t>(std::max(n, 0))));
  run_posted();
}

// --- descriptors

void Loop::hand_out(std::span<epoll_event> events) {
  for (epoll_event& event : events) {
    if (event.data.ptr == nullptr) continue;  // removed in this turn
    if (event.data.ptr == this) {
      on_time(os::now());
      continue;
    }
    auto& watch = *static_cast<Watch*>(event.data.ptr);
    const bool broken = (event.events & (EPOLLERR | EPOLLHUP)) != 0;
    const Ready ready{.to_read = broken || (event.events & (EPOLLIN | EPOLLRDHUP)) != 0,
                      .to_write = broken || (event.events & EPOLLOUT) != 0};
    // The watch, and everything the function holds, may be destroyed during the call.
    auto on_ready = std::move(watch.on_ready_);
    on_ready(ready);
    if (event.data.ptr != nullptr) watch.on_ready_ = std::move(on_ready);
  }
}

void Loop::forget(const Watch& watch) {
  for (epoll_event& event : events_) {
    if (event.data.ptr == &watch) event.data.ptr = nullptr;
  }
}

Watch::Watch(Loop& loop, int fd, std::function<void(Ready)> on_ready, Interest interest)
    : loop_(loop), fd_(fd), on_ready_(std::move(on_ready)) {
  set(interest);
}

Watch::~Watch() {
  set(Interest::kNothing);
  loop_.forget(*this);
}

// A descriptor without interest is removed, because epoll would still report its errors.
void Watch::set(Interest interest) {
  if (interest == interest_) return;
  const int change = interest_ == Interest::kNothing  ? EPOLL_CTL_ADD
                     : interest == Interest::kNothing ? EPOLL_CTL_DEL
                                                      : EPOLL_CTL_MOD;
  epoll_event event{.events = static_cast<std::uint32_t>(interest), .data = {.ptr = this}};
  ::epoll_ctl(loop_.epoll_.get(), change, fd_, &event);
  interest_ = interest;
}

// --- posted actions

void Loop::run_posted() {
  running_.swap(posted_);
  for (const auto& action : running_) action();
  running_.clear();
}

// --- time

Time Loop::next_deadline() const {
  Time next = timers_.empty() ? kNever : timers_.begin()->first;
  for (const Deadlines& d : deadlines_) next = std::min(next, d.next());
  return next;
}

// A deadline moved to a later time costs nothing: the alarm finds nothing to do and is set again.
void Loop::arm(Time at) {
  if (at >= armed_) return;
  armed_ = at;
  const itimerspec when{.it_interval = {},
                        // 0 would disarm it.
                        .it_value = os::to_timespec(std::max(at, Time(Duration(1))))};
  ::timerfd_settime(alarm_.get(), TFD_TIMER_ABSTIME, &when, nullptr);
}

void Loop::on_time(Time now) {
  armed_ = kNever;
  bool something = false;
  for (const Deadlines& d : deadlines_) {
    if (d.next() > now) continue;
    d.on_timeout(now);
    something = true;
  }
  while (!timers_.empty() && timers_.begin()->first <= now) {
    run_timer(*timers_.begin()->second);
    something = true;
  }
  if (something) end_turn(now);
}

void Loop::run_timer(Timer& timer) {
  timer.cancel();
  timer_at_work_ = &timer;
  // As with a watch: the timer may be destroyed during the call.
  auto on_timeout = std::move(timer.on_timeout_);
  on_timeout();
  if (timer_at_work_ != nullptr) timer.on_timeout_ = std::move(on_timeout);
  timer_at_work_ = nullptr;
}

Timer::Timer(Loop& loop, std::function<void()> on_timeout)
    : loop_(loop), on_timeout_(std::move(on_timeout)) {}

Timer::~Timer() {
  cancel();
  if (loop_.timer_at_work_ == this) loop_.timer_at_work_ = nullptr;
}

void Timer::set(Time at) {
  if (at_ != kNever) loop_.timers_.erase({at_, this});
  if (at != kNever) loop_.timers_.emplace(at, this);
  at_ = at;
}

}  // namespace tims::io

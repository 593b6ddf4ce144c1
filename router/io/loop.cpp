#include "router/io/loop.h"

#include <algorithm>
#include <chrono>

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "os/clock.h"

namespace tims::io {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using SystemClock = std::chrono::steady_clock;  // CLOCK_MONOTONIC, as os::now()

constexpr bool contains(Interest interest, Interest part) {
  return (static_cast<unsigned>(interest) & static_cast<unsigned>(part)) != 0;
}

}  // namespace

// Handlers run on one thread; only Asio's resolver posts from another one.
Loop::Loop()
    : context_(std::make_unique<asio::io_context>(BOOST_ASIO_CONCURRENCY_HINT_UNSAFE_IO)),
      alarm_(std::make_unique<Timer>(*this, [this] { on_alarm(); })) {}

Loop::~Loop() = default;

void Loop::end_turn(Time began) {
  for (const auto& step : steps_) step(began);
  longest_turn_ = std::max(longest_turn_, os::now() - began);
}

void Loop::post(std::function<void()> action) { asio::post(*context_, std::move(action)); }

void Loop::run() {
  while (!stopped_) run_once(kNever);
}

void Loop::run_once(Time limit) {
  const auto keep_waiting = asio::make_work_guard(*context_);
  arm(std::min(next_deadline(), limit));
  context_->run_one();
}

// --- deadlines

Time Loop::next_deadline() const {
  Time next = kNever;
  for (const Deadlines& d : deadlines_) next = std::min(next, d.next());
  return next;
}

// A deadline moved to a later time costs nothing: the alarm finds nothing to do and is set again.
void Loop::arm(Time at) {
  if (at >= armed_) return;
  armed_ = at;
  alarm_->set(at);
}

void Loop::on_alarm() {
  armed_ = kNever;
  const Time now = os::now();
  for (const Deadlines& d : deadlines_)
    if (d.next() <= now) d.on_timeout(now);
}

// --- descriptors

struct Watch::State : std::enable_shared_from_this<Watch::State> {
  State(Loop& loop, int fd, std::function<void(Ready)> function)
      : descriptor(loop.context()), on_ready(std::move(function)) {
    error_code ignored;  // the system watches no more descriptors: this one is never ready
    descriptor.assign(fd, ignored);
  }

  // Starts the waits that are missing. A wait that is no longer wanted stays, and is ignored.
  void wait() {
    wait_for(Interest::kReading, reading_waits, asio::posix::descriptor_base::wait_read);
    wait_for(Interest::kWriting, writing_waits, asio::posix::descriptor_base::wait_write);
  }

  void wait_for(Interest part, bool& waits, asio::posix::descriptor_base::wait_type type) {
    if (waits || !contains(interest, part)) return;
    waits = true;
    descriptor.async_wait(type, [self = shared_from_this(), part, &waits](error_code error) {
      waits = false;
      if (!error) self->call(part);
    });
  }

  void call(Interest part) {
    if (ended || !contains(interest, part)) return;
    on_ready({.to_read = part == Interest::kReading, .to_write = part == Interest::kWriting});
    if (!ended) wait();
  }

  asio::posix::stream_descriptor descriptor;
  std::function<void(Ready)> on_ready;
  Interest interest = Interest::kNothing;
  bool reading_waits = false;
  bool writing_waits = false;
  bool ended = false;
};

Watch::Watch(Loop& loop, int fd, std::function<void(Ready)> on_ready, Interest interest)
    : state_(std::make_shared<State>(loop, fd, std::move(on_ready))) {
  set(interest);
}

Watch::~Watch() {
  state_->ended = true;
  state_->descriptor.release();
}

void Watch::set(Interest interest) {
  state_->interest = interest;
  state_->wait();
}

// --- timers

struct Timer::State {
  State(Loop& its_loop, std::function<void()> function)
      : loop(its_loop), timer(loop.context()), on_timeout(std::move(function)) {}

  void call() {
    const Time began = os::now();
    at = kNever;
    on_timeout();
    loop.end_turn(began);
  }

  Loop& loop;
  asio::steady_timer timer;
  std::function<void()> on_timeout;
  Time at = kNever;
};

Timer::Timer(Loop& loop, std::function<void()> on_timeout)
    : state_(std::make_shared<State>(loop, std::move(on_timeout))) {}

Timer::~Timer() { cancel(); }

// A wait may have expired already when its timer is set again; it then finds another time.
void Timer::set(Time at) {
  state_->at = at;
  state_->timer.expires_at(SystemClock::time_point(at.time_since_epoch()));
  if (at == kNever) return;
  state_->timer.async_wait([state = state_, at](error_code error) {
    if (!error && state->at == at) state->call();
  });
}

}  // namespace tims::io

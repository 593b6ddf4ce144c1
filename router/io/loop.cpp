#include "router/io/loop.h"

#include <algorithm>
#include <chrono>

#include <boost/asio/detail/reactor.hpp>
#include <boost/asio/io_context.hpp>
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

// Asio's async_wait() asks the system for each wait whether the descriptor is ready (epoll_ctl).
// Here a descriptor of which everything was taken waits without asking: Asio registers descriptors
// edge-triggered, so that whatever arrives from now on is an event of its own. That needs an
// operation of Asio's reactor, whose interface is not documented; nothing else uses it.
struct Watch::State : std::enable_shared_from_this<Watch::State> {
  using Reactor = asio::detail::reactor;

  // Waits for one direction; pending while it holds the state.
  struct Wait : asio::detail::reactor_op {
    Wait() : reactor_op({}, &Wait::on_event, &Wait::on_complete) {}

    static status on_event(reactor_op* base) {
      return static_cast<Wait*>(base)->starts ? not_done : done;
    }
    static void on_complete(void* scheduler, asio::detail::operation* base, const error_code&,
                            std::size_t) {
      Wait& wait = *static_cast<Wait*>(base);
      const auto state = std::move(wait.state);
      const bool is_shut_down = scheduler == nullptr;
      if (!is_shut_down) state->call(wait);
    }

    std::shared_ptr<State> state;
    bool starts = false;  // Asio tries an operation before it waits
  };

  State(Loop& loop, int its_fd, std::function<void(Ready)> function)
      : reactor(asio::use_service<Reactor>(loop.context())),
        fd(its_fd),
        on_ready(std::move(function)) {
    reactor.init_task();
    // A failure means that the system watches no more descriptors: this one is never ready.
    (void)reactor.register_descriptor(fd, registration);
  }

  // Starts the waits that are missing. A wait that is no longer wanted stays, and is ignored.
  void wait() {
    const bool took_all = std::exchange(has_taken_all, false);
    if (contains(interest, Interest::kReading)) start(Reactor::read_op, reading, took_all);
    if (contains(interest, Interest::kWriting)) start(Reactor::write_op, writing, false);
  }

  void start(int direction, Wait& wait, bool is_for_next_event) {
    if (wait.state) return;
    wait.state = shared_from_this();
    wait.starts = is_for_next_event;
    reactor.start_op(direction, fd, registration, &wait, false, is_for_next_event);
    wait.starts = false;
  }

  void call(const Wait& waited) {
    const Interest part = &waited == &reading ? Interest::kReading : Interest::kWriting;
    if (ended || !contains(interest, part)) return;
    on_ready({.to_read = part == Interest::kReading, .to_write = part == Interest::kWriting});
    if (!ended) wait();
  }

  void end() {
    ended = true;
    reactor.deregister_descriptor(fd, registration, false);
    reactor.cleanup_descriptor_data(registration);
  }

  Reactor& reactor;
  Reactor::per_descriptor_data registration{};
  const int fd;
  std::function<void(Ready)> on_ready;
  Interest interest = Interest::kNothing;
  Wait reading;
  Wait writing;
  bool has_taken_all = false;  // of what there was to read, as its owner reported
  bool ended = false;
};

Watch::Watch(Loop& loop, int fd, std::function<void(Ready)> on_ready, Interest interest)
    : state_(std::make_shared<State>(loop, fd, std::move(on_ready))) {
  set(interest);
}

Watch::~Watch() { state_->end(); }

void Watch::set(Interest interest) {
  state_->interest = interest;
  state_->wait();
}

void Watch::all_taken() { state_->has_taken_all = true; }

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

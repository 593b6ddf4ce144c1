// The event loop, which runs on a single thread. A turn is one event (bytes arrived, a timer
// expired) and everything that follows from it; it begins with reading the clock and ends with
// end_turn().
//
// Descriptors are registered permanently (Watch), and the system timer is set only when the next
// deadline is earlier than before: beyond its own system calls, a message costs one epoll_wait().
// A time-out parameter would set a timer in each call, which takes as long as a message in a
// virtual machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <sys/epoll.h>

#include "os/file.h"
#include "tims/time.h"

namespace tims::io {

class Timer;
class Watch;

class Loop {
 public:
  // A component with deadlines, queried after every turn.
  struct Deadlines {
    std::function<Time()> next;            // kNever: none
    std::function<void(Time)> on_timeout;  // at or after next()
  };

  Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  // Must be called before run(). Steps executed at the end of each turn, in this order.
  void at_turn_end(std::function<void(Time)> step) { steps_.push_back(std::move(step)); }
  void watch(Deadlines deadlines) { deadlines_.push_back(std::move(deadlines)); }

  // Called after an event was handled; `began` is the start of its turn.
  void end_turn(Time began);
  // Executes the action in a turn of its own, after the others.
  void post(std::function<void()> action) { posted_.push_back(std::move(action)); }

  // Runs until stop().
  void run();
  // Waits once, at most until about `limit`, and handles the events.
  void run_once(Time limit);
  void stop() { stopped_ = true; }

  [[nodiscard]] Duration longest_turn() const { return longest_turn_; }

 private:
  friend Timer;
  friend Watch;
  static constexpr int kEventsMax = 64;

  [[nodiscard]] Time next_deadline() const;
  void arm(Time at);
  void hand_out(std::span<epoll_event> events);
  void run_posted();
  void on_time(Time now);
  void run_timer(Timer& timer);
  void forget(const Watch& watch);

  os::File epoll_;
  os::File alarm_;                                // a timerfd
  Time armed_ = kNever;                           // its expiry time
  std::array<epoll_event, kEventsMax> events_{};  // some may not be dispatched yet
  std::vector<std::function<void()>> posted_;
  std::vector<std::function<void()>> running_;  // posted before this turn
  std::set<std::pair<Time, Timer*>> timers_;    // the active ones
  Timer* timer_at_work_ = nullptr;
  std::vector<std::function<void(Time)>> steps_;
  std::vector<Deadlines> deadlines_;
  Duration longest_turn_{};
  bool stopped_ = false;
};

// Readiness of a descriptor; both are set when it is broken.
struct Ready {
  bool to_read = false;
  bool to_write = false;
};

enum class Interest : std::uint32_t {
  kNothing = 0,
  kReading = EPOLLIN,
  kWriting = EPOLLOUT,
  kBoth = EPOLLIN | EPOLLOUT,
  // Reports each change of readiness once, not continuously.
  kChanges = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET,
};

// A descriptor registered in the loop: the owner is called as long as it is ready.
class Watch {
 public:
  // `fd` must stay open during the lifetime. The owner may destroy the watch in the callback.
  Watch(Loop& loop, int fd, std::function<void(Ready)> on_ready,
        Interest interest = Interest::kReading);
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  ~Watch();

  void set(Interest interest);

 private:
  friend Loop;
  Loop& loop_;
  const int fd_;
  std::function<void(Ready)> on_ready_;
  Interest interest_ = Interest::kNothing;
};

// Calls its owner once at a given time.
class Timer {
 public:
  // The owner may destroy the timer in the callback.
  Timer(Loop& loop, std::function<void()> on_timeout);
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  ~Timer();

  // Replaces the previous time.
  void set(Time at);
  void cancel() { set(kNever); }

 private:
  friend Loop;
  Loop& loop_;
  std::function<void()> on_timeout_;
  Time at_ = kNever;
};

}  // namespace tims::io

// The one thread everything runs in. A turn is one thing that happened (bytes came, a timer ran
// out) and all that follows from it; it begins with a reading of the clock and ends with
// end_turn().
//
// Descriptors are watched once and for all (Watch), and the system's timer is set only when the
// next deadline comes earlier than before: what a message costs beside its own system calls is one
// epoll_wait(). With a time-out of its own that would set a timer each time, which in a virtual
// machine takes as long as a message.
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
  // Something with deadlines of its own, asked after every turn.
  struct Deadlines {
    std::function<Time()> next;            // kNever: none
    std::function<void(Time)> on_timeout;  // at or after next()
  };

  Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  // To be set up before run(). What is done at the end of each turn, in this order.
  void at_turn_end(std::function<void(Time)> step) { steps_.push_back(std::move(step)); }
  void watch(Deadlines deadlines) { deadlines_.push_back(std::move(deadlines)); }

  // Whoever handles something calls this when done; `began` is when its turn did.
  void end_turn(Time began);
  // A turn of its own, when others have had theirs.
  void post(std::function<void()> action) { posted_.push_back(std::move(action)); }

  // Until stop().
  void run();
  // Waits once, until about `limit` at most, and handles what is ready then.
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
  Time armed_ = kNever;                           // when it runs out
  std::array<epoll_event, kEventsMax> events_{};  // of which some are not handed out yet
  std::vector<std::function<void()>> posted_;
  std::vector<std::function<void()>> running_;  // that were posted before
  std::set<std::pair<Time, Timer*>> timers_;    // that are set
  Timer* timer_at_work_ = nullptr;
  std::vector<std::function<void(Time)>> steps_;
  std::vector<Deadlines> deadlines_;
  Duration longest_turn_{};
  bool stopped_ = false;
};

// What a descriptor is ready for; for both when it is broken.
struct Ready {
  bool to_read = false;
  bool to_write = false;
};

enum class Interest : std::uint32_t {
  kNothing = 0,
  kReading = EPOLLIN,
  kWriting = EPOLLOUT,
  kBoth = EPOLLIN | EPOLLOUT,
  // Once whenever it becomes ready for anything, not as long as it is.
  kChanges = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET,
};

// A descriptor in the loop's care: the owner is called as long as it is ready.
class Watch {
 public:
  // `fd` stays open as long as this lives. The owner may destroy the watch when it is called.
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

// Calls its owner once when a time has come.
class Timer {
 public:
  // The owner may destroy the timer when it is called.
  Timer(Loop& loop, std::function<void()> on_timeout);
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;
  ~Timer();

  // Instead of what it was set to before.
  void set(Time at);
  void cancel() { set(kNever); }

 private:
  friend Loop;
  Loop& loop_;
  std::function<void()> on_timeout_;
  Time at_ = kNever;
};

}  // namespace tims::io

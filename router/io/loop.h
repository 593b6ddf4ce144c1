// The event loop: Boost.Asio's io_context on a single thread. A turn is one event (bytes arrived, a
// timer expired) and everything that follows from it; it begins with reading the clock and ends
// with end_turn().
//
// Descriptors stay registered (Watch), and the system timer is set only when the next deadline is
// earlier than before: beyond its own system calls, a message costs one epoll_wait().
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "tims/time.h"

namespace boost::asio {
class io_context;
}

namespace tims::io {

class Timer;

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
  ~Loop();

  // For Asio's own sockets, acceptors and signals. Their handlers call end_turn().
  [[nodiscard]] boost::asio::io_context& context() { return *context_; }

  // Must be called before run(). Steps executed at the end of each turn, in this order.
  void at_turn_end(std::function<void(Time)> step) { steps_.push_back(std::move(step)); }
  void watch(Deadlines deadlines) { deadlines_.push_back(std::move(deadlines)); }

  // Called after an event was handled; `began` is the start of its turn.
  void end_turn(Time began);
  // Executes the action in a turn of its own, after the others.
  void post(std::function<void()> action);

  // Runs until stop().
  void run();
  // Waits for one event, at most until about `limit`, and handles it.
  void run_once(Time limit);
  void stop() { stopped_ = true; }

  [[nodiscard]] Duration longest_turn() const { return longest_turn_; }

 private:
  [[nodiscard]] Time next_deadline() const;
  void arm(Time at);
  void on_alarm();

  std::unique_ptr<boost::asio::io_context> context_;
  std::unique_ptr<Timer> alarm_;  // of the deadlines
  Time armed_ = kNever;           // its expiry time
  std::vector<std::function<void(Time)>> steps_;
  std::vector<Deadlines> deadlines_;
  Duration longest_turn_{};
  bool stopped_ = false;
};

// Readiness of a descriptor. One that is broken is ready for what its owner waits for.
struct Ready {
  bool to_read = false;
  bool to_write = false;
};

enum class Interest : std::uint8_t {
  kNothing = 0,
  kReading = 1,
  kWriting = 2,
  kBoth = kReading | kWriting,
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
  // In the callback, by an owner that took everything there was to read: it is called for the next
  // arrival, without the system being asked whether more is ready. The end of a connection, which
  // may arrive with its last bytes, is something to read, too.
  void all_taken();

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the pending waits
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
  struct State;
  std::shared_ptr<State> state_;  // shared with the pending wait
};

}  // namespace tims::io

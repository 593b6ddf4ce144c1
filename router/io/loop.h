// The one thread everything runs in. A turn is one thing that happened (bytes came, a timer ran
// out) and all that follows from it; it begins with the only reading of the clock.
#pragma once

#include <functional>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include "tims/time.h"

namespace tims::io {

class Loop {
 public:
  // Something with deadlines of its own, asked after every turn.
  struct Deadlines {
    std::function<Time()> next;            // kNever: none
    std::function<void(Time)> on_timeout;  // at or after next()
  };

  Loop();

  boost::asio::io_context& context() { return context_; }

  // To be set up before run(). What is done at the end of each turn, in this order.
  void at_turn_end(std::function<void(Time)> step) { steps_.push_back(std::move(step)); }
  void watch(Deadlines deadlines) { deadlines_.push_back(std::move(deadlines)); }

  // Whoever handles something calls this when done; `began` is when its turn did.
  void end_turn(Time began);

  void run();
  void stop() { context_.stop(); }

  [[nodiscard]] Duration longest_turn() const { return longest_turn_; }

 private:
  void arm_timer();
  void on_timer();

  boost::asio::io_context context_;
  boost::asio::steady_timer timer_;
  Time armed_ = kNever;  // when timer_ runs out
  std::vector<std::function<void(Time)>> steps_;
  std::vector<Deadlines> deadlines_;
  Duration longest_turn_{};
};

}  // namespace tims::io

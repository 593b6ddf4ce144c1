// Boost.Beast's WebSocket wants an io_context of Boost.Asio. Here it has neither a thread nor a
// wait of its own: the router's loop lets it run when something was asked of it and when a
// GuestSocket is done with something. It has no timers, which would need more than that.
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>

#include "router/io/loop.h"

namespace tims::io {

class AsioGuest {
 public:
  explicit AsioGuest(Loop& loop) : loop_(loop) {}
  AsioGuest(const AsioGuest&) = delete;
  AsioGuest& operator=(const AsioGuest&) = delete;

  boost::asio::io_context& context() { return context_; }
  Loop& loop() { return loop_; }

  // Something may be ready: to be looked at in a turn of its own.
  void wake();

 private:
  void run();

  Loop& loop_;
  boost::asio::io_context context_{BOOST_ASIO_CONCURRENCY_HINT_UNSAFE};
  // It is never done: without work it would stop.
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{
      context_.get_executor()};
  bool awake_ = false;
};

}  // namespace tims::io

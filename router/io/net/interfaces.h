// Tells when addresses, carrier or routes of this host change.
#pragma once

#include <functional>

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>

#include "os/file.h"
#include "router/io/net/debounce.h"
#include "tims/result.h"

namespace tims::io {

class InterfaceWatch {
 public:
  // Called once for changes close together (Debounce), from the loop. There may have been none that
  // matters, as when a router renews an address: whoever's reaction is costly compares.
  InterfaceWatch(boost::asio::io_context& loop, std::function<void()> on_change);
  InterfaceWatch(const InterfaceWatch&) = delete;
  InterfaceWatch& operator=(const InterfaceWatch&) = delete;
  ~InterfaceWatch();

  // From here on; once.
  Result<void> start();

 private:
  void wait();
  bool take();
  void put_off();
  void on_timer();

  std::function<void()> on_change_;
  os::File file_;
  boost::asio::posix::stream_descriptor socket_;  // waits for file_, which closes it
  boost::asio::steady_timer timer_;
  Debounce debounce_;
};

}  // namespace tims::io

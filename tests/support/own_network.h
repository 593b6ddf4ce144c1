// A network namespace for one test, with its own interfaces, addresses and routes.
#pragma once

#include <string>

#include "os/file.h"
#include "tims/result.h"

namespace tims::test {

// enter() moves the calling thread into a new namespace whose loopback is up; sockets and programs
// created there stay in it. The destructor, in the same thread, returns to the previous namespace.
class OwnNetwork {
 public:
  // Needs root; the error states this.
  static Result<OwnNetwork> enter();
  // With this address on its loopback interface, from where a router with keys allows nothing in
  // the clear.
  static Result<OwnNetwork> enter_with(const std::string& address);

  OwnNetwork(OwnNetwork&&) noexcept = default;
  OwnNetwork& operator=(OwnNetwork&&) = delete;
  ~OwnNetwork();

  // The largest datagram over the loopback in bytes, headers included.
  static Result<void> set_loopback_mtu(int bytes);

 private:
  explicit OwnNetwork(os::File before) : before_(std::move(before)) {}
  os::File before_;
};

}  // namespace tims::test

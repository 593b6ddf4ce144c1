// A network namespace for one test: interfaces, addresses and routes that nobody else has.
#pragma once

#include <string>

#include "os/file.h"
#include "tims/result.h"

namespace tims::test {

// From enter() on the calling thread is in a new namespace, with a loopback that is up; sockets
// made and programs started there stay in it. The destructor, in the same thread, goes back.
class OwnNetwork {
 public:
  // Needs the rights of root: the error says so.
  static Result<OwnNetwork> enter();

  OwnNetwork(OwnNetwork&&) noexcept = default;
  OwnNetwork& operator=(OwnNetwork&&) = delete;
  ~OwnNetwork();

  // What one datagram over the loopback may have, headers included.
  static Result<void> set_loopback_mtu(int bytes);

 private:
  explicit OwnNetwork(os::File before) : before_(std::move(before)) {}
  os::File before_;
};

}  // namespace tims::test

// Two hosts connected by a cable (veth), for one test: two network namespaces; the calling thread
// is in the left one.
#pragma once

#include <string>

#include "os/file.h"
#include "tests/support/own_network.h"
#include "tims/result.h"

namespace tims::test {

class TwoNetworks {
 public:
  static constexpr const char* kLeft = "10.78.0.1";
  static constexpr const char* kRight = "10.78.0.2";

  // Needs root; the error states this.
  static Result<TwoNetworks> enter();

  // Sockets and programs that `act` creates are in the right namespace.
  template <typename Act>
  auto on_the_right(Act act) const {
    const Visit visit(right_, left_);
    return act();
  }
  // Runs shell commands (ip, nft) in the left namespace, or in the right one within on_the_right().
  static Result<void> run(const std::string& commands);

 private:
  struct Visit {
    Visit(const os::File& there, const os::File& home);
    ~Visit();
    const os::File& back;
  };
  explicit TwoNetworks(OwnNetwork network) : outer_(std::move(network)) {}
  Result<void> join();

  OwnNetwork outer_;  // returns to the namespace of the test
  os::File right_{};
  os::File left_{};
};

}  // namespace tims::test

// Two hosts connected by a cable (veth), for one test: two network namespaces; the calling thread
// is in the left one. A third host may hide behind the right one, which masquerades it (NAT).
#pragma once

#include <string>

#include "os/file.h"
#include "tests/support/own_network.h"
#include "tims/result.h"

namespace tims::test {

// Moves the calling thread into another network namespace, and back at its end.
struct NetworkVisit {
  NetworkVisit(const os::File& there, const os::File& home);
  NetworkVisit(const NetworkVisit&) = delete;
  NetworkVisit& operator=(const NetworkVisit&) = delete;
  ~NetworkVisit();
  const os::File& back;
};

class TwoNetworks {
 public:
  static constexpr const char* kLeft = "10.78.0.1";
  static constexpr const char* kRight = "10.78.0.2";

  // Needs root; the error states this.
  static Result<TwoNetworks> enter();

  // Sockets and programs that `act` creates are in the right namespace.
  template <typename Act>
  auto on_the_right(Act act) const {
    const NetworkVisit visit(right_, left_);
    return act();
  }
  // Runs shell commands (ip, nft) in the left namespace, or in the one visited.
  static Result<void> run(const std::string& commands);

 private:
  explicit TwoNetworks(OwnNetwork network) : outer_(std::move(network)) {}
  Result<void> join();

  OwnNetwork outer_;  // returns to the namespace of the test
  os::File right_{};
  os::File left_{};
};

// The third host reaches the left one by NAT, and cannot be reached from there.
class HiddenNetwork {
 public:
  static constexpr const char* kAddress = "192.168.78.2";

  // Call once. `networks` must exist as long.
  Result<void> hide_behind(const TwoNetworks& networks);
  // As TwoNetworks::on_the_right().
  template <typename Act>
  auto inside(Act act) const {
    const NetworkVisit visit(hidden_, left_);
    return act();
  }

 private:
  os::File hidden_{};
  os::File left_{};
};

}  // namespace tims::test

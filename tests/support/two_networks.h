// Two hosts joined by a cable, for one test: network namespaces of which the calling thread is in
// the left one.
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

  // Needs the rights of root: the error says so.
  static Result<TwoNetworks> enter();

  // What `act` opens and starts is on the right.
  template <typename Act>
  auto on_the_right(Act act) const {
    const Visit visit(right_, left_);
    return act();
  }
  // Lines for the shell (ip, nft): on the left, or on the right within on_the_right().
  static Result<void> run(const std::string& commands);

 private:
  struct Visit {
    Visit(const os::File& there, const os::File& home);
    ~Visit();
    const os::File& back;
  };
  explicit TwoNetworks(OwnNetwork network) : outer_(std::move(network)) {}
  Result<void> join();

  OwnNetwork outer_;  // the right one; goes back to where the test came from
  os::File right_{};
  os::File left_{};
};

}  // namespace tims::test

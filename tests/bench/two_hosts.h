// Two hosts on this machine, the base and the robot: network namespaces connected by a cable of
// configurable quality. They are removed with the object.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tims/result.h"
#include "tools/sim/plan.h"

namespace tims::bench {

using Cable = timsctl::sim::Quality;  // the same in both directions; faults that the kernel does
                                      // not support are omitted

// The reason why hosts cannot be created; empty if they can.
std::string why_no_hosts();
// Removes the namespaces of this process; also used when it is ended by a signal.
void remove_own_hosts();
// Removes the namespaces of runs that were killed.
void remove_abandoned_hosts();

class TwoHosts {
 public:
  enum class Side { kBase, kRobot };

  static Result<std::unique_ptr<TwoHosts>> make(const Cable& cable);
  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;
  ~TwoHosts() { remove_own_hosts(); }

  static std::string address(Side side);
  // The prefix of commands that run there.
  [[nodiscard]] std::vector<std::string> enter(Side side) const;

  // Unplugs the cable.
  [[nodiscard]] Result<void> cut() const;
  // A filter at the robot drops datagrams to and from this UDP port until it is removed.
  [[nodiscard]] Result<void> block_udp(const std::string& port) const;
  [[nodiscard]] Result<void> unblock_udp() const;
  // Bytes received from the cable on this side, Ethernet headers included.
  [[nodiscard]] Result<double> received(Side side) const;

 private:
  TwoHosts();
  void set_up(const Cable& cable) const;  // throws Failure
  void set_up(const timsctl::sim::LineEnd& end, const Cable& cable) const;
  static void wait_for_carrier(const timsctl::sim::LineEnd& end);
  [[nodiscard]] const timsctl::sim::LineEnd& end(Side side) const;

  timsctl::sim::LineEnd base_;
  timsctl::sim::LineEnd robot_;
};

}  // namespace tims::bench

// Two hosts on this machine, the base and the robot: network namespaces joined by a cable that is
// as bad as one wants it. They go with the object.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tims/result.h"
#include "tools/sim/plan.h"

namespace tims::bench {

using Cable = timsctl::sim::Quality;  // alike both ways; what the kernel cannot do is left out

// Why there can be none: empty when there can.
std::string why_no_hosts();
// Takes away the namespaces of this process. For the end by a signal, too.
void remove_own_hosts();
// What runs that were killed have left.
void remove_abandoned_hosts();

class TwoHosts {
 public:
  enum class Side { kBase, kRobot };

  static Result<std::unique_ptr<TwoHosts>> make(const Cable& cable);
  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;
  ~TwoHosts() { remove_own_hosts(); }

  static std::string address(Side side);
  // What stands before a command that runs there.
  [[nodiscard]] std::vector<std::string> enter(Side side) const;

  // Pulls the cable.
  [[nodiscard]] Result<void> cut() const;
  // A filter at the robot takes what goes to or comes from this port of UDP, until it is taken
  // away.
  [[nodiscard]] Result<void> block_udp(const std::string& port) const;
  [[nodiscard]] Result<void> unblock_udp() const;
  // Bytes that have come out of the cable on this side, Ethernet headers included.
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

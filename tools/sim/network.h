// The plan's namespaces and cables, made real; and the quality of the cables.
#pragma once

#include <string>
#include <vector>

#include "os/process.h"
#include "tools/cli/failure.h"
#include "tools/cli/json.h"
#include "tools/sim/plan.h"

namespace timsctl::sim {

class Network {
 public:
  explicit Network(const Plan& plan) : plan_(plan) {}

  void make();  // throws Failure
  // What the kernel does of it; the routers do the rest (router_faults).
  void apply(const Line& line, const LineState& before, const LineState& state) const;
  // Can the kernel delay, double and reorder by itself?
  [[nodiscard]] bool netem() const { return netem_; }

 private:
  void apply(const LineEnd& sender, const LineEnd& receiver, const Quality& before,
             const Quality& quality) const;

  const Plan& plan_;
  bool netem_ = false;
};

// Namespaces of that fleet which are there, whoever made them.
std::vector<std::string> networks_of(std::string_view fleet);
// Ends what runs in them, and takes them away.
void remove_networks(const std::vector<std::string>& networks);

// What makes a line bad, as text for tc and nft. Pure. What leaves an interface is shaped by tc,
// what comes in is thrown away by nft; what neither can do is the routers' part.

// For `tc`, at the sending end. Without netem only the rate.
tims::os::Command shaping(const LineEnd& sender, const Quality& quality, bool netem);

// For `nft -f -`, at the receiving end: takes the place of what was there.
std::string dropping(const LineEnd& receiver, const Quality& quality);

// What the router at the sending end is asked to do: delay, jitter, doubles and changes of the
// order, when the kernel has no netem. `link` is the router's name for the link.
json::object router_faults(const std::string& link, const Quality& quality);
bool needs_router(const Quality& quality);
// All of it, of a router that nobody helps; an empty `link`: all its links.
json::object all_faults(const std::string& link, const Quality& quality);

}  // namespace timsctl::sim

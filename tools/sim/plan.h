// A fleet on this machine: which namespaces, interfaces, addresses and router configurations.
//
// The base has a bridge, "wifi", with one port for the first host of each robot. Each other host of
// a robot has a line to the first one. IP is not forwarded: only messages pass from host to host.
//
// First the plan (pure), then its implementation by `ip`, `tc` and `nft`.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "os/process.h"
#include "tools/cli/output.h"
#include "tools/sim/fleet_file.h"

namespace timsctl::sim {

struct Component {
  std::string label;  // "tims-demo ladar --at Ladar(1/0)"
  tims::os::Command command;
};

struct PlannedHost {
  std::string name;     // "robot1-main"
  std::string network;  // its namespace: "tims-demo-robot1-main"
  std::string role;     // of its router: "top", "system", "subsystem"
  std::uint8_t system = 0;
  std::uint8_t id = 1;
  std::vector<std::string> addresses;  // "10.0.0.1/24"
  std::string folder;                  // "/run/tims-sim/demo/robot1-main"
  std::string router_config;           // text of router.toml
  std::vector<std::string> settings;   // --set
  std::vector<std::string> robots;     // robot files that are copied to robot_file()
  std::vector<Component> components;

  [[nodiscard]] std::string socket() const { return folder + "/router.sock"; }
  [[nodiscard]] std::string keys() const { return folder + "/keys"; }
  // Its configuration, as /etc/tims of an installed host, and what its agent keeps.
  [[nodiscard]] std::string files() const { return folder + "/etc"; }
  [[nodiscard]] std::string agent_state() const { return folder + "/agent"; }
  [[nodiscard]] std::string config_file() const { return files() + "/router.toml"; }
  [[nodiscard]] std::string robot_file(std::string_view source) const;
};

struct LineEnd {
  std::string host;
  std::string network;
  std::string device;   // named after the other end
  std::string address;  // "10.0.0.1/24"; empty: the bridge has it
};

struct Line {
  std::string name;  // "robot1-base"
  LineEnd upper;
  LineEnd lower;
  LineState own;  // without faults
};

// What its routers trust: keys of the fleet, or everybody in its networks.
enum class Trust : std::uint8_t { kKeys, kEverybody };

struct Plan {
  std::string name;
  Trust trust = Trust::kKeys;
  std::string folder;           // "/run/tims-sim/demo"
  std::string programs_folder;  // working folder of components: that of the fleet file; empty: the
                                // current folder
  std::vector<PlannedHost>
      hosts;  // the base first; the first host of a robot before its other hosts
  std::vector<Line> lines;
  Profiles profiles;
  std::vector<Step> steps;

  [[nodiscard]] const PlannedHost* find_host(std::string_view host) const;
};

inline constexpr std::string_view kSimFolder = "/run/tims-sim";

Plan make_plan(const Fleet& fleet, Trust trust = Trust::kKeys);

// The environment of the programs of a host: its router, and a separate runtime folder.
std::vector<std::string> environment_at(const std::string& router_socket);

std::string network_prefix(std::string_view fleet);  // "tims-demo-"

// Input of `ip -batch -`: all namespaces and the cables between them.
std::string network_commands(const Plan& plan);
// Input of `ip -n NAMESPACE -batch -`: commands within one namespace.
std::string host_commands(const Plan& plan, const PlannedHost& host);

// Names of robots, hosts and lines. Pure.

inline constexpr std::int64_t kSystemMax =
    250;  // the address of a robot at the base is 10.0.0.SYSTEM
inline constexpr std::size_t kHostsMax = 200;     // per robot
inline constexpr std::size_t kRobotNameMax = 10;  // an interface of the base is named after it
inline constexpr std::size_t kHostNameMax = 12;

inline constexpr std::string_view kBase = "base";

std::string host_name(const Robot& robot, std::string_view host);  // "robot1-main"
// "robot1-base" for the first host, "robot1-arm" for the others: the line to the host above.
std::string line_name(const Robot& robot, std::string_view host);
std::vector<std::string> host_names_of(const Fleet& fleet);
std::vector<std::string> line_names(const Fleet& fleet);

// --- implementation of the plan

class Network {
 public:
  explicit Network(const Plan& plan) : plan_(plan) {}

  void make();  // throws Failure
  // Applies the part that the kernel supports; the routers apply the rest (router_faults).
  void apply(const Line& line, const LineState& before, const LineState& state) const;
  // Whether the kernel has netem (delay, duplicates, reordering).
  [[nodiscard]] bool netem() const { return netem_; }

 private:
  void apply(const LineEnd& sender, const LineEnd& receiver, const Quality& before,
             const Quality& quality) const;

  const Plan& plan_;
  bool netem_ = false;
};

// The existing namespaces of that fleet, including leftovers.
std::vector<std::string> networks_of(std::string_view fleet);
// Kills the processes in the namespaces and removes them.
void remove_networks(const std::vector<std::string>& networks);

// Line faults as input of tc and nft. Pure. tc shapes outgoing packets, nft drops incoming ones;
// the routers apply the rest.

// For `tc` at the sending end. Without netem only the rate is limited.
tims::os::Command shaping(const LineEnd& sender, const Quality& quality, bool netem);

// For `nft -f -` at the receiving end; replaces earlier rules.
std::string dropping(const LineEnd& receiver, const Quality& quality);

// The request to the router at the sending end for delay, jitter, duplicates and reordering, if the
// kernel has no netem. `link`: the name of the link at that router.
json::object router_faults(const std::string& link, const Quality& quality);
bool needs_router(const Quality& quality);
// All faults, for a router without help of the kernel. An empty `link`: all its links.
json::object all_faults(const std::string& link, const Quality& quality);

}  // namespace timsctl::sim

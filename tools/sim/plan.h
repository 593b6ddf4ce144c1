// A fleet on this machine: which namespaces, interfaces, addresses and router configurations.
//
// The base has a bridge, "wifi", with one port for each robot's first host; a robot's other hosts
// hang at the first one by a line each. Nothing forwards IP: from host to host go only messages.
//
// First the plan (pure), then what `ip`, `tc` and `nft` make of it.
#pragma once

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
  std::vector<Component> components;

  [[nodiscard]] std::string socket() const { return folder + "/router.sock"; }
  [[nodiscard]] std::string config_file() const { return folder + "/router.toml"; }
};

struct LineEnd {
  std::string host;
  std::string network;
  std::string device;   // called after the other end
  std::string address;  // "10.0.0.1/24"; empty: the bridge has it
};

struct Line {
  std::string name;  // "robot1-base"
  LineEnd upper;
  LineEnd lower;
  LineState own;  // without faults
};

struct Plan {
  std::string name;
  std::string folder;              // "/run/tims-sim/demo"
  std::string programs_folder;     // components run there: the fleet file's; empty: timsctl's own
  std::vector<PlannedHost> hosts;  // the base first, a robot's first host before its others
  std::vector<Line> lines;
  Profiles profiles;
  std::vector<Step> steps;

  [[nodiscard]] const PlannedHost* find_host(std::string_view host) const;
  [[nodiscard]] const Line* find_line(std::string_view line) const;
};

inline constexpr std::string_view kSimFolder = "/run/tims-sim";

Plan make_plan(const Fleet& fleet);

// What programs of a host find in their environment: its router, and a folder of its own for what
// runs there.
std::vector<std::string> environment_at(const std::string& router_socket);

std::string network_prefix(std::string_view fleet);  // "tims-demo-"

// Input of `ip -batch -`: all namespaces and the cables between them.
std::string network_commands(const Plan& plan);
// Input of `ip -n NAMESPACE -batch -`: what is done inside of one.
std::string host_commands(const Plan& plan, const PlannedHost& host);

// How robots, hosts and lines are called. Pure.

inline constexpr std::int64_t kSystemMax = 250;   // a robot's address at the base is 10.0.0.SYSTEM
inline constexpr std::size_t kHostsMax = 200;     // of a robot
inline constexpr std::size_t kRobotNameMax = 10;  // an interface of the base is called after it
inline constexpr std::size_t kHostNameMax = 12;

inline constexpr std::string_view kBase = "base";

std::string host_name(const Robot& robot, std::string_view host);  // "robot1-main"
// "robot1-base" for the first host, "robot1-arm" for the others: the line to the host above.
std::string line_name(const Robot& robot, std::string_view host);
std::vector<std::string> host_names_of(const Fleet& fleet);
std::vector<std::string> line_names(const Fleet& fleet);

// --- the plan made real

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

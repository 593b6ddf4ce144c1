#include "tools/sim/plan.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>

#include <fmt/format.h>

#include "base/text.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"

namespace timsctl::sim {

namespace {

constexpr std::string_view kBridge = "wifi";
constexpr std::string_view kBaseAddress = "10.0.0.254";

std::string without_prefix(std::string_view address) {
  return std::string(address.substr(0, address.find('/')));
}

// The configuration common to all hosts. `links`: the [[link]] tables.
std::string router_config(const PlannedHost& host, Trust trust, const std::string& links) {
  const std::string security = trust == Trust::kKeys ? fmt::format("keys = \"{}\"", host.keys())
                                                     : std::string("insecure = true");
  return fmt::format(R"([router]
name = "{}"
role = "{}"
system = {}
id = {}
[unix]
path = "{}"
[security]
{}
[udp]
listen = "0.0.0.0:2010"
[tcp]
listen = "0.0.0.0:2000"
admin = true   # the console may change this host
[http]
listen = "0.0.0.0:8080"
[sim]
faults = true
{})",
                     host.name, host.role, host.system, host.id, host.socket(), security, links);
}

std::string super_link(const Line& line, std::string_view upper_address) {
  return fmt::format("[[link]]\nkind = \"super\"\nto = \"{}:2010\"\nname = \"{}\"\n",
                     without_prefix(upper_address), line.name);
}

class Planner {
 public:
  Planner(const Fleet& fleet, Trust trust) : fleet_(fleet) {
    plan_.name = fleet.name;
    plan_.trust = trust;
    plan_.folder = fmt::format("{}/{}", kSimFolder, fleet.name);
    plan_.profiles = fleet.profiles;
    plan_.steps = fleet.steps;
  }

  Plan make() {
    add_base();
    for (const Robot& robot : fleet_.robots) add_robot(robot);
    return std::move(plan_);
  }

 private:
  PlannedHost host(std::string name) const {
    PlannedHost host;
    host.network = network_prefix(fleet_.name) + name;
    host.folder = fmt::format("{}/{}", plan_.folder, name);
    host.name = std::move(name);
    return host;
  }

  static void give_programs(PlannedHost& host, const HostPrograms& programs,
                            const std::string& robot) {
    const base::Placeholders values{
        {"robot", robot}, {"host", host.name}, {"system", std::to_string(host.system)}};
    host.settings = programs.settings;
    host.robots = programs.robots;
    for (const tims::os::Command& command : programs.components) {
      tims::os::Command filled;
      for (const std::string& argument : command)
        filled.push_back(base::filled_in(argument, values));
      host.components.push_back({fmt::format("{}", fmt::join(filled, " ")), filled});
    }
    for (const std::string& robot_file : programs.robots)
      host.components.push_back(
          {fmt::format("timsctl up {}", std::filesystem::path(robot_file).filename().string()),
           {"timsctl", "up", host.robot_file(robot_file)}});
  }

  void add_base() {
    PlannedHost base = host(std::string(kBase));
    base.role = "top";
    base.addresses = {fmt::format("{}/24", kBaseAddress)};
    base.router_config =
        router_config(base, plan_.trust, "[[link]]\nkind = \"sub\"\nsystem = \"*\"\n");
    give_programs(base, fleet_.base, std::string(kBase));
    plan_.hosts.push_back(std::move(base));
  }

  void add_robot(const Robot& robot) {
    PlannedHost first = host(host_name(robot, robot.hosts.front()));
    first.role = "system";
    first.system = robot.system;
    first.addresses = {fmt::format("10.0.0.{}/24", robot.system)};
    const Quality& radio = fleet_.profiles.at(robot.link);
    const Line& line =
        plan_.lines.emplace_back(Line{.name = line_name(robot, robot.hosts.front()),
                                      .upper = {.host = std::string(kBase),
                                                .network = plan_.hosts.front().network,
                                                .device = robot.name,
                                                .address = {}},
                                      .lower = {.host = first.name,
                                                .network = first.network,
                                                .device = std::string(kBase),
                                                .address = first.addresses.front()},
                                      .own = {.up = radio, .down = radio}});
    std::string links = super_link(line, kBaseAddress);
    if (robot.hosts.size() > 1)
      links += fmt::format("[[link]]\nkind = \"sub\"\nsystem = {}\n", robot.system);
    first.router_config = router_config(first, plan_.trust, links);
    give_programs(first, robot.programs.at(robot.hosts.front()), robot.name);
    plan_.hosts.push_back(first);
    const std::size_t first_index = plan_.hosts.size() - 1;
    for (std::size_t i = 1; i < robot.hosts.size(); ++i) add_other(robot, i, first_index);
  }

  void add_other(const Robot& robot, std::size_t number, std::size_t first_index) {
    PlannedHost other = host(host_name(robot, robot.hosts[number]));
    other.role = "subsystem";
    other.system = robot.system;
    other.id = static_cast<std::uint8_t>(number + 1);
    other.addresses = {fmt::format("10.{}.{}.2/24", robot.system, number)};
    const std::string upper_address = fmt::format("10.{}.{}.1/24", robot.system, number);
    const Quality& cable = fleet_.profiles.at(robot.cable);
    PlannedHost& first = plan_.hosts[first_index];
    first.addresses.push_back(upper_address);
    const Line& line = plan_.lines.emplace_back(Line{.name = line_name(robot, robot.hosts[number]),
                                                     .upper = {.host = first.name,
                                                               .network = first.network,
                                                               .device = robot.hosts[number],
                                                               .address = upper_address},
                                                     .lower = {.host = other.name,
                                                               .network = other.network,
                                                               .device = robot.hosts.front(),
                                                               .address = other.addresses.front()},
                                                     .own = {.up = cable, .down = cable}});
    other.router_config = router_config(other, plan_.trust, super_link(line, upper_address));
    give_programs(other, robot.programs.at(robot.hosts[number]), robot.name);
    plan_.hosts.push_back(std::move(other));
  }

  const Fleet& fleet_;
  Plan plan_;
};

void append_device(const LineEnd& end, std::string& out) {
  // One datagram per packet: loss must affect single datagrams, not bursts (GSO).
  out += fmt::format("link set dev {0} gso_max_segs 1\nlink set dev {0} addrgenmode none\n",
                     end.device);
  if (end.address.empty())
    out += fmt::format("link set dev {} master {}\n", end.device, kBridge);
  else
    out += fmt::format("address add {} dev {}\n", end.address, end.device);
  out += fmt::format("link set dev {} up\n", end.device);
}

}  // namespace

std::string PlannedHost::robot_file(std::string_view source) const {
  return fmt::format("{}/robots/{}", files(), std::filesystem::path(source).filename().string());
}

const PlannedHost* Plan::find_host(std::string_view host) const {
  const auto found = std::ranges::find(hosts, host, &PlannedHost::name);
  return found == hosts.end() ? nullptr : &*found;
}

std::vector<std::string> environment_at(const std::string& router_socket) {
  return {"TIMS_ROUTER=" + router_socket,
          "TIMS_HOST=", "XDG_RUNTIME_DIR=" + router_socket.substr(0, router_socket.rfind('/'))};
}

Plan make_plan(const Fleet& fleet, Trust trust) { return Planner(fleet, trust).make(); }

std::string network_prefix(std::string_view fleet) { return fmt::format("tims-{}-", fleet); }

std::string network_commands(const Plan& plan) {
  std::string out;
  for (const PlannedHost& host : plan.hosts) out += fmt::format("netns add {}\n", host.network);
  for (const Line& line : plan.lines)
    out +=
        fmt::format("link add name {} netns {} type veth peer name {} netns {}\n",
                    line.upper.device, line.upper.network, line.lower.device, line.lower.network);
  return out;
}

std::string host_commands(const Plan& plan, const PlannedHost& host) {
  std::string out = "link set dev lo up\n";
  if (&host == &plan.hosts.front())
    out += fmt::format(
        "link add name {0} type bridge\nlink set dev {0} addrgenmode none\n"
        "address add {1} dev {0}\nlink set dev {0} up\n",
        kBridge, host.addresses.front());
  for (const Line& line : plan.lines)
    for (const LineEnd* end : {&line.upper, &line.lower})
      if (end->network == host.network) append_device(*end, out);
  return out;
}

std::string host_name(const Robot& robot, std::string_view host) {
  return fmt::format("{}-{}", robot.name, host);
}

std::string line_name(const Robot& robot, std::string_view host) {
  return fmt::format("{}-{}", robot.name, host == robot.hosts.front() ? kBase : host);
}

std::vector<std::string> host_names_of(const Fleet& fleet) {
  std::vector<std::string> names = {std::string(kBase)};
  for (const Robot& robot : fleet.robots)
    for (const std::string& host : robot.hosts) names.push_back(host_name(robot, host));
  return names;
}

std::vector<std::string> line_names(const Fleet& fleet) {
  std::vector<std::string> names;
  for (const Robot& robot : fleet.robots)
    for (const std::string& host : robot.hosts) names.push_back(line_name(robot, host));
  return names;
}

// --- implementation of the plan

void Network::make() {
  run_or_fail({.command = {"ip", "-batch", "-"}}, network_commands(plan_));
  for (const PlannedHost& host : plan_.hosts)
    run_or_fail({.command = {"ip", "-n", host.network, "-batch", "-"}}, host_commands(plan_, host));
  // Tests for netem with a temporary qdisc on an unused interface.
  const std::string& first = plan_.hosts.front().network;
  netem_ = run({.command = {"tc", "-n", first, "qdisc", "add", "dev", "lo", "root", "netem",
                            "delay", "1ms"}})
               .status.success();
  if (netem_) run_or_fail({.command = {"tc", "-n", first, "qdisc", "del", "dev", "lo", "root"}});
  for (const Line& line : plan_.lines) apply(line, {}, line.own);
}

void Network::apply(const Line& line, const LineState& before, const LineState& state) const {
  apply(line.lower, line.upper, before.up, state.up);
  apply(line.upper, line.lower, before.down, state.down);
  if (before.cut == state.cut) return;
  // One end is enough: the other one loses its carrier.
  run_or_fail({.command = {"ip", "-n", line.upper.network, "link", "set", "dev", line.upper.device,
                           state.cut ? "down" : "up"}});
}

void Network::apply(const LineEnd& sender, const LineEnd& receiver, const Quality& before,
                    const Quality& quality) const {
  const tims::os::Command shape = shaping(sender, quality, netem_);
  if (shape != shaping(sender, before, netem_)) run_or_fail({.command = shape});
  const std::string drop = dropping(receiver, quality);
  if (drop != dropping(receiver, before))
    run_or_fail({.command = {"nft", "-f", "-"}, .network = receiver.network}, drop);
}

std::vector<std::string> networks_of(std::string_view fleet) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/run/netns", ignored)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(network_prefix(fleet))) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

void remove_networks(const std::vector<std::string>& networks) {
  std::string commands;
  for (const std::string& network : networks) {
    for (const pid_t pid : tims::os::processes_in(network)) ::kill(pid, SIGKILL);
    commands += fmt::format("netns del {}\n", network);
  }
  if (!networks.empty()) run_or_fail({.command = {"ip", "-force", "-batch", "-"}}, commands);
}

namespace {

constexpr std::uint64_t kShares = 1'000'000;    // loss in millionths
constexpr std::uint64_t kBurstBytesMin = 3028;  // two packets
constexpr int kQueueMs = 100;                   // packets that wait longer are dropped

double ms(tims::Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

tims::os::Command netem(tims::os::Command command, const Quality& quality) {
  command.emplace_back("netem");
  const auto add = [&](std::initializer_list<std::string> more) {
    command.insert(command.end(), more);
  };
  // Jitter increases the delay; the jitter of netem is symmetric about the delay.
  const double half = ms(quality.jitter) / 2;
  const double delay = ms(quality.delay) + half;
  if (delay > 0 || quality.reorder > 0)
    add({"delay", fmt::format("{:.3f}ms", std::max(delay, 5.0 * (quality.reorder > 0))),
         fmt::format("{:.3f}ms", half)});
  if (quality.duplicate > 0) add({"duplicate", fmt::format("{:g}%", quality.duplicate * 100)});
  // netem sends this share at once and delays the others.
  if (quality.reorder > 0) add({"reorder", fmt::format("{:g}%", quality.reorder * 100)});
  if (quality.rate_bits > 0) add({"rate", fmt::format("{}bit", quality.rate_bits)});
  return command;
}

}  // namespace

tims::os::Command shaping(const LineEnd& sender, const Quality& quality, bool has_netem) {
  tims::os::Command command = {"tc",      "-n",  sender.network, "qdisc",
                               "replace", "dev", sender.device,  "root"};
  if (has_netem && needs_router(quality)) return netem(std::move(command), quality);
  if (quality.rate_bits == 0) {
    command.emplace_back("noqueue");
    return command;
  }
  // The burst corresponds to five milliseconds.
  const std::uint64_t burst = std::max(quality.rate_bits / 8 / 200, kBurstBytesMin);
  for (std::string argument :
       {std::string("tbf"), std::string("rate"), fmt::format("{}bit", quality.rate_bits),
        std::string("burst"), std::to_string(burst), std::string("latency"),
        fmt::format("{}ms", kQueueMs)})
    command.push_back(std::move(argument));
  return command;
}

std::string dropping(const LineEnd& receiver, const Quality& quality) {
  const std::string table = "table netdev tims_" + receiver.device;
  // Declared first: deleting a missing table is an error.
  std::string text = fmt::format("{0}\ndelete {0}\n", table);
  const auto lost = static_cast<std::uint64_t>(std::llround(quality.loss * double{kShares}));
  if (!quality.blackout && lost == 0) return text;
  text += fmt::format(
      "{} {{\n  chain faults {{\n    type filter hook ingress device \"{}\" priority 0;\n", table,
      receiver.device);
  if (quality.blackout || lost >= kShares)
    text += "    drop\n";
  else
    text += fmt::format("    numgen random mod {} < {} drop\n", kShares, lost);
  return text + "  }\n}\n";
}

bool needs_router(const Quality& quality) {
  return quality.delay > tims::Duration{} || quality.jitter > tims::Duration{} ||
         quality.duplicate > 0 || quality.reorder > 0;
}

json::object router_faults(const std::string& link, const Quality& quality) {
  return {{"ask", "fault"},
          {"link", link},
          {"duplicate", quality.duplicate},
          {"reorder", quality.reorder},
          {"delay_s", ms(quality.delay) / 1000},
          {"jitter_s", ms(quality.jitter) / 1000}};
}

json::object all_faults(const std::string& link, const Quality& quality) {
  json::object question = router_faults(link, quality);
  if (link.empty()) question.erase("link");
  question["loss"] = quality.loss;
  question["rate"] = quality.rate_bits / 8;
  question["blackout"] = quality.blackout;
  return question;
}

}  // namespace timsctl::sim

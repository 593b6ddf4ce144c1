#include "tools/timsctl/sim/network.h"

#include <algorithm>
#include <csignal>
#include <filesystem>

#include <fmt/format.h>

#include "tools/timsctl/process.h"
#include "tools/timsctl/sim/rules.h"

namespace timsctl::sim {

void Network::make() {
  run_or_fail({.command = {"ip", "-batch", "-"}}, network_commands(plan_));
  for (const PlannedHost& host : plan_.hosts)
    run_or_fail({.command = {"ip", "-n", host.network, "-batch", "-"}}, host_commands(plan_, host));
  // A throw-away one, where nobody is yet.
  const std::string& first = plan_.hosts.front().network;
  netem_ = run({.command = {"tc", "-n", first, "qdisc", "add", "dev", "lo", "root", "netem",
                            "delay", "1ms"}})
               .code == 0;
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
  const CommandLine shape = shaping(sender, quality, netem_);
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
    for (const pid_t pid : processes_in(network)) ::kill(pid, SIGKILL);
    commands += fmt::format("netns del {}\n", network);
  }
  if (!networks.empty()) run_or_fail({.command = {"ip", "-force", "-batch", "-"}}, commands);
}

}  // namespace timsctl::sim

#include "tools/sim/network.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>

#include <fmt/format.h>

#include "tools/cli/failure.h"
#include "tools/cli/service.h"

namespace timsctl::sim {

void Network::make() {
  run_or_fail({.command = {"ip", "-batch", "-"}}, network_commands(plan_));
  for (const PlannedHost& host : plan_.hosts)
    run_or_fail({.command = {"ip", "-n", host.network, "-batch", "-"}}, host_commands(plan_, host));
  // A throw-away one, where nobody is yet.
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
constexpr int kQueueMs = 100;                   // what waits longer for the rate is lost

double ms(tims::Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

tims::os::Command netem(tims::os::Command words, const Quality& quality) {
  words.emplace_back("netem");
  const auto add = [&](std::initializer_list<std::string> more) {
    words.insert(words.end(), more);
  };
  // The jitter is on top: netem's lies on both sides of the delay.
  const double half = ms(quality.jitter) / 2;
  const double delay = ms(quality.delay) + half;
  if (delay > 0 || quality.reorder > 0)
    add({"delay", fmt::format("{:.3f}ms", std::max(delay, 5.0 * (quality.reorder > 0))),
         fmt::format("{:.3f}ms", half)});
  if (quality.duplicate > 0) add({"duplicate", fmt::format("{:g}%", quality.duplicate * 100)});
  // netem sends the share at once and holds the others back.
  if (quality.reorder > 0) add({"reorder", fmt::format("{:g}%", quality.reorder * 100)});
  if (quality.rate_bits > 0) add({"rate", fmt::format("{}bit", quality.rate_bits)});
  return words;
}

}  // namespace

tims::os::Command shaping(const LineEnd& sender, const Quality& quality, bool has_netem) {
  tims::os::Command words = {"tc",      "-n",  sender.network, "qdisc",
                             "replace", "dev", sender.device,  "root"};
  if (has_netem && needs_router(quality)) return netem(std::move(words), quality);
  if (quality.rate_bits == 0) {
    words.emplace_back("noqueue");
    return words;
  }
  // Five milliseconds may go at once.
  const std::uint64_t burst = std::max(quality.rate_bits / 8 / 200, kBurstBytesMin);
  for (std::string word :
       {std::string("tbf"), std::string("rate"), fmt::format("{}bit", quality.rate_bits),
        std::string("burst"), std::to_string(burst), std::string("latency"),
        fmt::format("{}ms", kQueueMs)})
    words.push_back(std::move(word));
  return words;
}

std::string dropping(const LineEnd& receiver, const Quality& quality) {
  const std::string table = "table netdev tims_" + receiver.device;
  // Declared first: what is not there cannot be deleted.
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

#include "tests/bench/two_hosts.h"

#include <csignal>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

#include "tests/bench/metrics.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/sim/plan.h"
#include "tools/sim/supervisor.h"

namespace tims::bench {
namespace {

namespace sim = timsctl::sim;

constexpr const char* kDevice = "cable";
// Named like fleets, so that `timsctl sim show` lists remaining ones and `timsctl sim down` removes
// them.
constexpr std::string_view kName = "bench";

// Named after the process that created them; its forked copy (scratch.cpp) keeps the name.
const std::string& own_name() {
  static const std::string name = std::string(kName) + std::to_string(::getpid());
  return name;
}

// Converts failures of timsctl's functions to results.
template <typename Act>
Result<void> tried(Act act) {
  try {
    act();
    return {};
  } catch (const timsctl::Failure& failure) {
    return Error(Errc::kSystem, failure.message);
  }
}

sim::LineEnd end_of(const std::string& host, TwoHosts::Side side) {
  return {.host = host,
          .network = sim::network_prefix(own_name()) + host,
          .device = kDevice,
          .address = TwoHosts::address(side)};
}

}  // namespace

std::string why_no_hosts() {
  if (::geteuid() != 0) return "network namespaces need root";
  for (const char* program : {"ip", "tc", "nft"}) {
    const auto found = tried([&] { (void)timsctl::run({.command = {program, "-V"}}); });
    if (!found) return found.error().detail();
  }
  const auto made = TwoHosts::make({});
  return made ? "" : made.error().detail();
}

void remove_own_hosts() {
  (void)tried([] { sim::remove_networks(sim::networks_of(own_name())); });
}

void remove_abandoned_hosts() {
  for (const std::string& name : sim::fleets()) {
    pid_t owner = 0;
    if (!name.starts_with(kName) || !(std::istringstream(name.substr(kName.size())) >> owner))
      continue;
    const bool abandoned = ::kill(owner, 0) != 0 && !sim::running_fleets().is_running(name);
    if (abandoned) (void)tried([&] { sim::clean_up(name); });
  }
}

Result<std::unique_ptr<TwoHosts>> TwoHosts::make(const Cable& cable) {
  std::unique_ptr<TwoHosts> hosts(new TwoHosts);
  if (auto done = tried([&] { hosts->set_up(cable); }); !done) return done.error();
  return hosts;
}

TwoHosts::TwoHosts() : base_(end_of("base", Side::kBase)), robot_(end_of("robot", Side::kRobot)) {}

void TwoHosts::set_up(const Cable& cable) const {
  timsctl::run_or_fail({.command = {"ip", "-batch", "-"}},
                       "netns add " + base_.network + "\nnetns add " + robot_.network +
                           "\nlink add name " + kDevice + " netns " + base_.network +
                           " type veth peer name " + kDevice + " netns " + robot_.network + "\n");
  set_up(base_, cable);
  set_up(robot_, cable);
  wait_for_carrier(base_);
  wait_for_carrier(robot_);
}

// The kernel reports a device as up with a delay of up to a second, and DDS ignores devices that
// are not.
void TwoHosts::wait_for_carrier(const sim::LineEnd& end) {
  for (int tries = 0; tries < 500; ++tries) {
    const auto shown = timsctl::run(
        {.command = {"ip", "link", "show", "dev", kDevice, "up"}, .network = end.network});
    if (shown.output.find("state UP") != std::string::npos) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw timsctl::Failure(timsctl::Exit::kTimeout, "no_cable",
                         "the cable between two hosts does not come up");
}

void TwoHosts::set_up(const sim::LineEnd& end, const Cable& cable) const {
  const std::string device = std::string("link set dev ") + kDevice;
  // Without IPv6, whose neighbour discovery would be measured as well.
  std::string commands = "link set dev lo up\n" + device + " addrgenmode none\n";
  // Loss applies to datagrams, not to the bursts in which they are sent.
  if (cable.loss > 0) commands += device + " gso_max_segs 1\n";
  commands += "address add " + end.address + "/24 dev " + kDevice + "\n" + device + " up\n";
  timsctl::run_or_fail({.command = {"ip", "-n", end.network, "-batch", "-"}}, commands);
  if (cable.rate_bits > 0) timsctl::run_or_fail({.command = sim::shaping(end, cable, false)});
  if (cable.loss > 0)
    timsctl::run_or_fail({.command = {"nft", "-f", "-"}, .network = end.network},
                         sim::dropping(end, cable));
}

const sim::LineEnd& TwoHosts::end(Side side) const { return side == Side::kBase ? base_ : robot_; }

std::string TwoHosts::address(Side side) { return side == Side::kBase ? "10.77.0.1" : "10.77.0.2"; }

std::vector<std::string> TwoHosts::enter(Side side) const {
  return {"ip", "netns", "exec", end(side).network};
}

Result<void> TwoHosts::cut() const {
  return tried([this] {
    timsctl::run_or_fail(
        {.command = {"ip", "-n", robot_.network, "link", "set", "dev", kDevice, "down"}});
  });
}

Result<void> TwoHosts::block_udp(const std::string& port) const {
  std::string rules = "table inet blocked {\n";
  for (const std::string_view hook : {"input", "output"})
    rules += fmt::format(
        "chain {0} {{ type filter hook {0} priority 0; udp dport {1} drop; udp sport {1} drop; "
        "}}\n",
        hook, port);
  return tried([&] {
    timsctl::run_or_fail({.command = {"nft", "-f", "-"}, .network = robot_.network}, rules + "}\n");
  });
}

Result<void> TwoHosts::unblock_udp() const {
  return tried([&] {
    timsctl::run_or_fail(
        {.command = {"nft", "delete", "table", "inet", "blocked"}, .network = robot_.network});
  });
}

Result<double> TwoHosts::received(Side side) const {
  std::string text;
  auto read = tried([&] {
    text = timsctl::run({.command = {"cat", "/proc/net/dev"}, .network = end(side).network}).output;
  });
  if (!read) return read.error();
  return received_bytes(text, kDevice);
}

}  // namespace tims::bench

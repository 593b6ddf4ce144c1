#include "tests/bench/middle.h"

#include <algorithm>
#include <iterator>

#include "libtims/os/clock.h"
#include "tests/bench/addresses.h"
#include "tests/bench/admin.h"
#include "tests/bench/launch.h"
#include "tests/bench/router_command.h"
#include "tests/bench/rules.h"
#include "tools/sim/plan.h"

namespace tims::bench {
namespace {

constexpr std::string_view kListening = "listening tcp ";

}  // namespace

Middle::Middle(const Setting& setting, const Experiment& experiment, std::string folder)
    : setting_(setting), experiment_(experiment), folder_(std::move(folder)) {}

Result<void> Middle::start() {
  if (on_two_hosts(experiment_.between)) return start_on_two_hosts();
  const std::string socket = folder_ + "/router.sock";
  places_ = {Place{.socket = socket}};
  if (experiment_.between == Between::kNothing) return {};
  if (experiment_.between == Between::kRelay)
    return start_here({setting_.program, "--role", "relay"});
  std::vector<std::string> settings{"tcp.listen=127.0.0.1:0"};
  for (std::size_t i = 0; experiment_.with_rules && i < kRules; ++i)
    settings.push_back(rule_setting(i));
  return start_here(router_command(setting_.router, socket, std::move(settings)));
}

// Waits for the line that it prints when it is ready, and returns it.
Result<std::string> Middle::add(std::vector<std::string> command, const char* awaited) {
  auto process = launch(std::move(command), experiment_.one_cpu);
  if (!process) return process.error();
  processes_.push_back(std::move(*process));
  return processes_.back().wait_for_line(awaited, kStartLimit);
}

Result<void> Middle::start_here(std::vector<std::string> command) {
  const auto line = add(std::move(command), kListening.data());
  if (!line) return line.error();
  const std::string endpoint = line->substr(line->find(kListening) + kListening.size());
  places_.front().endpoint = endpoint.substr(0, endpoint.find_first_of(" ,\t"));
  return {};
}

Result<void> Middle::start_on_two_hosts() {
  auto hosts = TwoHosts::make(experiment_.cable);
  if (!hosts) return hosts.error();
  hosts_ = std::move(*hosts);
  for (const Side side : {Side::kBase, Side::kRobot}) {
    const Side other = side == Side::kBase ? Side::kRobot : Side::kBase;
    places_.push_back({.enter = hosts_->enter(side),
                       .address = TwoHosts::address(side),
                       .socket = folder_ + (side == Side::kBase ? "/base.sock" : "/robot.sock"),
                       .endpoint = TwoHosts::address(other) + kClientPort});
  }
  if (experiment_.between == Between::kTwoRouters) return start_routers();
  if (experiment_.between == Between::kTwoRelays) return start_relays();
  return {};
}

Result<void> Middle::start_routers() {
  if (auto made = make_keys(); !made) return made;
  const bool by_name = connects_by_name();
  const std::string base = TwoHosts::address(Side::kBase) + kRouterPort;
  if (auto started = add_router(Side::kBase, "listening udp",
                                {"router.name=base", "router.role=top", link("sub", "")});
      !started)
    return started;
  second_started_ = os::now();
  if (auto started = add_router(
          Side::kRobot, "is up",
          {"router.name=robot", "router.system=1", link("super", by_name ? "auto" : base)});
      !started)
    return started;
  const auto known = processes_.front().wait_for_line("is up", kStartLimit);
  return known ? delay_datagrams() : known.error();
}

std::string Middle::link(const char* kind, const std::string& to) const {
  const std::uint64_t rate = experiment_.rate_is_set ? experiment_.cable.rate_bits / 8 : 0;
  std::string text = std::string("link=kind=") + kind + ",rate=" + std::to_string(rate);
  if (!to.empty()) text += ",to=" + to;
  if (!experiment_.paths.empty()) text += ",paths=" + experiment_.paths;
  return text;
}

Result<void> Middle::make_keys() {
  if (!experiment_.sealed) return {};
  auto keys = FleetKeys::make(folder_ + "/keys");
  if (!keys) return keys.error();
  keys_ = std::move(*keys);
  if (auto made = keys_->add(security::MemberRole::kTop, 0, 1); !made) return made;
  return keys_->add(security::MemberRole::kSystem, 1, 1);
}

std::string Middle::trust(Side side) const {
  using enum security::MemberRole;
  if (!keys_) return "security.insecure=true";
  return "security.keys=" +
         (side == Side::kBase ? keys_->folder_of(kTop, 0, 1) : keys_->folder_of(kSystem, 1, 1));
}

Result<void> Middle::add_router(Side side, const char* awaited, std::vector<std::string> settings) {
  const Place& place = side == Side::kBase ? of_receivers() : of_senders();
  settings.insert(settings.end(), {"udp.listen=" + place.address + kRouterPort, "tcp.listen=off",
                                   trust(side), "sim.faults=true"});
  if (connects_by_name()) settings.emplace_back("fleet.name=bench");
  std::vector<std::string> command = place.enter;
  std::ranges::copy(router_command(setting_.router, place.socket, std::move(settings)),
                    std::back_inserter(command));
  const auto line = add(std::move(command), awaited);
  return line ? Result<void>() : line.error();
}

// Each router delays what it sends, because the kernel may lack netem.
Result<void> Middle::delay_datagrams() const {
  if (experiment_.cable.delay == Duration::zero()) return {};
  for (const auto& [place, peer] : {std::pair(of_receivers(), "robot"), {of_senders(), "base"}}) {
    auto admin = Admin::open(place.socket);
    if (!admin) return admin.error();
    const auto done = admin->ask(timsctl::sim::router_faults(peer, experiment_.cable));
    if (!done) return done.error();
  }
  return {};
}

Result<void> Middle::start_relays() {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    std::vector<std::string> command = places_[i].enter;
    command.insert(command.end(),
                   {setting_.program, "--role", "udp-relay", "--link", experiment_.link, "--host",
                    places_[i].address, "--endpoint", places_[1 - i].address + kRouterPort});
    if (auto line = add(std::move(command), "listening udp"); !line) return line.error();
    places_[i].endpoint = places_[i].address + kRouterPort;
  }
  return {};
}

Usage Middle::usage() const {
  Usage sum;
  for (const test::ChildProcess& process : processes_) sum = sum + usage_of(process.pid());
  return sum;
}

std::string Middle::output() const {
  std::string text;
  for (const test::ChildProcess& process : processes_) text += process.output();
  return text;
}

}  // namespace tims::bench

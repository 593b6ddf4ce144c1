#include "tests/sim/restart_storm.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace tims::sim {

using namespace std::chrono_literals;

namespace {

constexpr std::int8_t kNumbered = 21;  // a command
constexpr std::array<std::uint8_t, 3> kStormPriorities{5, 20, 110};
// Shorter than the silence after which the others believe a link to be down.
constexpr Duration kStormTime = 500ms;
constexpr Duration kTick = 4ms;
// After the last restart: its time, the return of its programs, and two handshakes.
constexpr Duration kCalmTime = 400ms;
constexpr Duration kCalmTimeOnABadLine = 3s;  // parts of a handshake are repeated after 300 ms
constexpr Duration kAfterStorms = 5s;

NodeSetup storm_node(const char* name, core::Role role, std::uint16_t system, std::uint16_t id,
                     std::vector<link::LinkSettings> links) {
  return {.name = name,
          .role = role,
          .system = system,
          .id = id,
          .links = std::move(links),
          .block_bytes = 4U << 20,
          .message_bytes = 4U << 20,
          .message_max = 1U << 16};
}

}  // namespace

RestartStorm::RestartStorm(std::uint64_t seed, bool verbose)
    : seed_(seed), network_(seed * 0x9E3779B97F4A7C15U + 4711), findings_(network_, verbose) {}

std::vector<std::string> RestartStorm::run() {
  try {
    build();
    begin_flows();
    for (int storm = 0; storm < 2; ++storm) {
      plan_storm();
      network_.run_for(kStormTime + (loses_ ? kCalmTimeOnABadLine : kCalmTime));
      check_links();
    }
    stopped_ = true;
    network_.run_for(kAfterStorms);
    check_messages();
  } catch (const std::exception& e) {
    fail(e.what());
  }
  return findings_.failures();
}

// --- the network

void RestartStorm::build() {
  if (seed_ % 2 == 0) network_.seal_all();
  loses_ = seed_ % 3 == 0;
  pause_ = between(1ms, 150ms);
  network_.set_faults({.loss = loses_ ? 0.01 * static_cast<double>(network_.random(15)) : 0,
                       .delay = between(100us, 4ms),
                       .jitter = between(0us, 1ms)});
  const auto add = [&](const NodeSetup& setup, std::vector<Address> mailboxes) {
    Node& node = network_.add(setup);
    const std::size_t host = hosts_.size();
    node.on_arrival = [this, host](Node&, core::ClientId, Arrival&& arrival) {
      take(host, arrival);
    };
    std::vector<core::ClientId> nobody(mailboxes.size());
    hosts_.push_back({.node = &node, .mailboxes = std::move(mailboxes), .programs = nobody});
  };
  add(storm_node("base", core::Role::kTop, 0, 1, {sub_link()}),
      {Address(0x00020000), Address(0x00030000)});
  add(storm_node("robot", core::Role::kSystem, 1, 1, {super_link(address_of(0)), sub_link()}),
      {Address(0x01140000)});
  if (network_.random(2) == 0)
    add(storm_node("host", core::Role::kSubsystem, 1, 2, {super_link(address_of(1))}),
        {Address(0x01150000), Address(0x01160000)});
  for (std::size_t host = 0; host < hosts_.size(); ++host) {
    hosts_[host].node->start(now());
    for (std::size_t program = 0; program < hosts_[host].mailboxes.size(); ++program)
      attach(host, program);
  }
  network_.run_for(1s);
}

void RestartStorm::begin_flows() {
  const std::size_t last = hosts_.size() - 1;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto [from, to] =
        i % 2 == 0 ? std::pair(std::size_t{0}, last) : std::pair(last, std::size_t{0});
    flows_.push_back({.from = from,
                      .to = to,
                      .program = i % hosts_[to].mailboxes.size(),
                      .priority = kStormPriorities[i / 2]});
  }
  tick();
}

// --- restarts

void RestartStorm::plan_storm() {
  storm_until_ = now() + kStormTime;
  const std::size_t first = network_.random(hosts_.size());
  for (std::size_t host = 0; host < hosts_.size(); ++host)
    if (host == first || network_.random(2) == 0) plan_restart(host, now() + between({}, 100ms));
}

void RestartStorm::plan_restart(std::size_t host, Time when) {
  if (when >= storm_until_) return;
  network_.at(when, [this, host] { restart(host); });
}

void RestartStorm::restart(std::size_t host) {
  Host& its = hosts_[host];
  print(its.node->setup().name + " ends" +
        (its.node->links().holds_back() ? ", before its programs are back" : ""));
  ++restarts_;
  ++its.run;
  its.left = its.node->hand_over(now());
  std::ranges::fill(its.programs, core::kNoClient);
  network_.at(now() + between(1ms, 30ms), [this, host] { start(host); });
}

void RestartStorm::start(std::size_t host) {
  Host& its = hosts_[host];
  const auto restored = its.node->start(now(), its.left);
  print(its.node->setup().name + " starts");
  std::size_t links = 0;
  its.node->links().for_each([&](const link::Link&) { ++links; });
  if (!restored || (!loses_ && *restored != links)) fail("not all links go on");
  for (std::size_t program = 0; program < its.mailboxes.size(); ++program)
    network_.at(now() + between(0ms, 25ms), [this, host, program, run = its.run] {
      if (hosts_[host].run == run) attach(host, program);
    });
  plan_restart(host, now() + between({}, 2 * pause_));
}

void RestartStorm::attach(std::size_t host, std::size_t program) {
  Host& its = hosts_[host];
  const Address address = its.mailboxes[program];
  const core::ClientId client = its.node->add_client(now(), address.to_string());
  if (!its.node->add_mailbox(now(), client, address)) fail("no mailbox " + address.to_string());
  its.programs[program] = client;
}

// --- traffic

void RestartStorm::tick() {
  if (stopped_) return;
  ++ticks_;
  for (Flow& flow : flows_)
    if (network_.random(3) == 0) send(flow);
  network_.at(now() + kTick, [this] { tick(); });
}

// A program whose router is away is told so: it sends nothing here.
void RestartStorm::send(Flow& flow) {
  Host& from = hosts_[flow.from];
  if (from.programs[0] == core::kNoClient) return;
  const auto flow_number = static_cast<std::uint32_t>(&flow - flows_.data());
  const std::uint32_t number = ++flow.sent;
  std::vector<std::byte> body(network_.random(20) == 0 ? 20'000 : 40);
  std::memcpy(body.data(), &number, sizeof number);
  std::memcpy(body.data() + sizeof number, &flow_number, sizeof flow_number);
  ++sent_;
  const core::Outcome outcome = from.node->send(now(), from.programs[0],
                                                {.type = kNumbered,
                                                 .priority = flow.priority,
                                                 .dest = hosts_[flow.to].mailboxes[flow.program],
                                                 .src = from.mailboxes[0]},
                                                body);
  if (outcome == core::Outcome::kDelivered) return;
  ++told_;
  if (!loses_)
    fail(from.node->setup().name + " refuses a message: " + std::string(core::name(outcome)));
}

void RestartStorm::take(std::size_t host, const Arrival& arrival) {
  if (arrival.header.type == type::kNotAvailable) {
    ++told_;
    print("NOT_AVAILABLE to " + arrival.header.dest.to_string() + " of " +
          arrival.header.src.to_string());
    return;
  }
  std::uint32_t number = 0;
  std::uint32_t flow_number = 0;
  std::memcpy(&number, arrival.body.data(), sizeof number);
  std::memcpy(&flow_number, arrival.body.data() + sizeof number, sizeof flow_number);
  Flow& flow = flows_.at(flow_number);
  if (flow.to != host) fail("a message came to the wrong host");
  if (number <= flow.newest)
    fail("message " + std::to_string(number) + " of flow " + std::to_string(flow_number) +
         " comes after " + std::to_string(flow.newest));
  if (number != flow.newest + 1)
    print("message " + std::to_string(number) + " of flow " + std::to_string(flow_number) +
          " comes after " + std::to_string(flow.newest));
  flow.newest = std::max(flow.newest, number);
  ++flow.arrived;
}

// --- what must be true

void RestartStorm::check_links() {
  for (Host& host : hosts_) {
    if (host.node->links().holds_back()) fail(host.node->setup().name + " waits for nobody");
    host.node->links().for_each([&](const link::Link& link) {
      if (!link.is_up() || link.keys().are_locked())
        fail("the link of " + host.node->setup().name + " is " + std::string(name(link.state())) +
             (link.keys().are_locked() ? ", without keys" : ""));
    });
  }
}

void RestartStorm::check_messages() {
  std::uint64_t missing = 0;
  for (const Flow& flow : flows_) missing += flow.sent - flow.arrived;
  if (missing > told_)
    fail(std::to_string(missing) + " messages have not arrived, and " + std::to_string(told_) +
         " senders were told");
  if (loses_) return;
  if (missing > 0) fail(std::to_string(missing) + " messages have not arrived");
  for (const Host& host : hosts_)
    for (const core::Event& event : host.node->events)
      if (event.kind == core::EventKind::kLinkDown)
        fail(host.node->setup().name + " believes a link to be down");
}

}  // namespace tims::sim

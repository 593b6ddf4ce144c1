// Swarm: the checks of its invariants.
#include <algorithm>

#include "tests/sim/swarm.h"

namespace tims::sim {

using namespace std::chrono_literals;

namespace {

constexpr Duration kIdle = 3s;
constexpr std::uint64_t kIdleBytesPerSecond = 500;  // per link and direction
constexpr std::uint64_t kIdleBytesOfTwoPaths = 1200;
constexpr std::uint64_t kIdleStepsPerSecond = 100;  // per link

}  // namespace

// --- tables

void Swarm::check_tables() {
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) check_table(i);
  for (const Client& client : clients_) {
    for (const std::size_t above : plan_.up_from(client.node)) {
      for (const Address address : client.mailboxes) {
        if (node(above).router().find(address) == nullptr)
          fail(address.to_string() + " of " + client.name + " is not known at " +
               node(above).setup().name);
      }
    }
  }
}

// The table has no entry of a client that has left, and none from another part of the tree.
void Swarm::check_table(std::size_t i) {
  std::size_t expected = 0;
  const auto reaches = [&](std::size_t from) {
    if (plan_.is_below(from, i)) return true;
    return std::ranges::any_of(plan_.nodes[i].peers,
                               [&](std::size_t peer) { return plan_.is_below(from, peer); });
  };
  for (const Client& client : clients_)
    if (reaches(client.node)) expected += client.mailboxes.size();
  for (std::size_t other = 0; other < plan_.nodes.size(); ++other)
    if (other != i && reaches(other)) ++expected;
  const std::size_t known = node(i).router().table().size();
  if (known != expected)
    fail(node(i).setup().name + " knows " + std::to_string(known) + " mailboxes, not " +
         std::to_string(expected));
}

std::size_t Swarm::waiting_from(std::size_t first) const {
  const auto& all = ledger_.entries();
  return static_cast<std::size_t>(
      std::count_if(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(),
                    [](const Ledger::Entry& e) { return !e.arrived && !e.answered; }));
}

// A temporary client at every router sends to every mailbox.
void Swarm::check_routes() {
  std::vector<Client> guests;
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) {
    const NodeSetup& setup = node(i).setup();
    Client guest{.node = i, .name = "guest at " + setup.name};
    guest.mailboxes = {
        Address::of({.system = setup.system, .class_id = 0x30, .instance = setup.id})};
    attach(guest);
    guests.push_back(guest);
  }
  const std::size_t before = ledger_.entries().size();
  for (Client& guest : guests) {
    for (Client& client : clients_)
      send(guest, guest.mailboxes[0], client, client.mailboxes[0], {.type = 9, .priority = 200}, 8);
  }
  network_.run_until([&] { return waiting_from(before) == 0; }, plan_.troubles.rates ? 60s : 500ms);
  for (std::size_t n = before; n < ledger_.entries().size(); ++n) {
    const Ledger::Entry& entry = ledger_.entries()[n];
    const bool reachable = !plan_.route(entry.from, entry.to).empty();
    if (entry.arrived != reachable)
      fail((reachable ? "did not arrive: " : "arrived without a route: ") +
           Ledger::describe(entry));
    if (!reachable && !entry.answered) fail("no NOT_AVAILABLE: " + Ledger::describe(entry));
  }
}

// --- losses

void Swarm::check_losses() {
  std::array<std::uint64_t, core::kClasses> missing{};
  std::array<std::string, core::kClasses> example;
  for (const Ledger::Entry& entry : ledger_.entries()) {
    ++totals_.messages;
    totals_.arrived += entry.arrived ? 1 : 0;
    if (entry.arrived || entry.is_sample() || !core::taken(entry.outcome)) continue;
    const auto route = plan_.route(entry.from, entry.to);
    if (route.empty()) continue;
    const bool lived = std::ranges::none_of(route, [&](std::size_t i) { return crashed_[i]; });
    if (!lived && plan_.has_single_routes) continue;
    if (!plan_.has_single_routes && plan_.troubles.crashes) continue;
    ++missing[entry.message_class()];
    example[entry.message_class()] = Ledger::describe(entry);
  }
  for (std::size_t c = 0; c < core::kClasses; ++c) {
    std::uint64_t counted = 0;
    for (std::size_t i = 0; i < plan_.nodes.size(); ++i) counted += node(i).lost(c);
    totals_.lost += counted;
    if (missing[c] > counted)
      fail(std::to_string(missing[c]) + " messages of class " + std::to_string(c) +
           " are lost, but only " + std::to_string(counted) +
           " were counted as lost: " + example[c]);
    if (missing[c] > 0 && plan_.troubles.are_mild() && plan_.has_single_routes)
      fail("lost although all faults were mild: " + example[c]);
  }
}

// A command that cannot be delivered is answered where there is a route back.
void Swarm::check_answers() {
  const Troubles& t = plan_.troubles;
  if (t.crashes || t.partitions || t.churn || t.loss || t.moves || t.short_lifetimes) return;
  // The answer may have been lost as well.
  std::array<std::uint64_t, core::kClasses> counted{};
  for (std::size_t c = 0; c < core::kClasses; ++c) {
    for (const auto& one : network_.nodes()) counted[c] += one->lost(c);
  }
  for (const Ledger::Entry& entry : ledger_.entries()) {
    if (entry.arrived || entry.answered || entry.header.type <= 0) continue;
    if ((t.small_queues || t.little_memory) && counted[entry.message_class()]-- > 0) continue;
    fail("a command without an answer: " + Ledger::describe(entry));
  }
}

// --- the idle network

// A link that has found its path small looks for a larger one some time later: that takes some
// large datagrams, but not for long.
void Swarm::check_idle() {
  constexpr int kSearches = 3;
  std::string problem = idle_problem();
  for (int i = 0; i < kSearches && !problem.empty(); ++i) problem = idle_problem();
  if (!problem.empty()) fail(problem);
}

std::string Swarm::idle_problem() {
  std::string problem;
  std::vector<std::uint64_t> before;
  for (const auto& one : network_.nodes()) before.push_back(network_.bytes_sent(one->setup().name));
  const std::uint64_t steps = network_.steps();
  network_.run_for(kIdle);
  std::uint64_t links = 0;
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) {
    std::uint64_t own = 0;
    node(i).links().for_each([&](const link::Link&) { ++own; });
    const std::uint64_t sent = network_.bytes_sent(node(i).setup().name) - before[i];
    const std::uint64_t each = plan_.troubles.dds ? kIdleBytesOfTwoPaths : kIdleBytesPerSecond;
    if (sent > own * each * 3)
      problem = node(i).setup().name + " is idle and sends " + std::to_string(sent / 3) +
                " bytes a second over " + std::to_string(own) + " links";
    links += own;
  }
  if (network_.steps() - steps > links * kIdleStepsPerSecond * 3)
    problem = "idle, and " + std::to_string((network_.steps() - steps) / 3) + " steps a second";
  return problem;
}

void Swarm::check_memory() {
  for (const auto& one : network_.nodes()) {
    if (one->memory_in_use() != 0)
      fail(one->setup().name + " still holds " + std::to_string(one->memory_in_use()) + " bytes");
    print(one->setup().name + " " + std::to_string(one->events.size()) + " events");
  }
}

void Swarm::check_events() {
  // One path of each link always works.
  const bool stays_up = plan_.troubles.half_cuts && !plan_.troubles.crashes &&
                        !plan_.troubles.loss && !plan_.troubles.rates;
  for (const auto& one : network_.nodes()) {
    for (const core::Event& event : one->events) {
      const bool wrong = event.kind == core::EventKind::kLoop ||
                         event.kind == core::EventKind::kDuplicateAddress ||
                         event.kind == core::EventKind::kDuplicateRouter ||
                         event.kind == core::EventKind::kLinkRefused ||
                         (event.kind == core::EventKind::kLinkDown && stays_up);
      if (wrong)
        fail(one->setup().name + " saw " + std::string(core::name(event.kind)) + " " +
             std::string(event.text.view()) + " " + event.address.to_string());
    }
  }
}

}  // namespace tims::sim

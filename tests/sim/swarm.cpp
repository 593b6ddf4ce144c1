#include "tests/sim/swarm.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace tims::sim {

using namespace std::chrono_literals;
using link::PathKind;

namespace {

// The time within which all tables must be right again once the network is.
constexpr Duration kConvergence = 2s;
// Extra time for links to the preferred super router: it is used again only after its link has been
// up for some time, and the other super router keeps its entries for some more time.
constexpr Duration kFailBack = 500ms;
constexpr Duration kDrain = 4s;
// Links with a limited rate may have some megabytes queued.
constexpr Duration kSlowDrain = 60s;

}  // namespace

Swarm::Swarm(std::uint64_t seed, bool verbose)
    : seed_(seed),
      network_(seed * 0x9E3779B97F4A7C15U + 12345),
      findings_(network_, verbose),
      ledger_([this](const std::string& what) { fail(what); }) {
  if (seed % 3 == 0) network_.seal_all();
}

std::vector<std::string> Swarm::run() {
  try {
    build();
    network_.run_for(1s + within(1500ms));
    // DDS paths are prepared in turns (PROTOCOL.md, section 7). Until its turn a link that loses
    // UDP is down.
    const Duration turns =
        plan_.troubles.dds ? 2s + static_cast<int>(plan_.nodes.size()) * 500ms : Duration{};
    if (plan_.troubles.half_cuts) network_.run_for(turns);
    const Duration span =
        500ms + within(plan_.troubles.partitions || plan_.troubles.half_cuts ? 6s : 2s);
    plan_trouble(span);
    plan_traffic(span, 30 + network_.random(120));
    network_.run_for(span);
    heal();
    network_.run_for(kConvergence + (plan_.has_single_routes ? 0ms : kFailBack));
    check_tables();
    check_routes();
    network_.run_for((plan_.troubles.rates ? kSlowDrain : kDrain) + turns);
    check_losses();
    check_answers();
    check_idle();
    check_memory();
    check_events();
  } catch (const std::exception& e) {
    fail(e.what());
  }
  totals_.datagrams = network_.datagrams();
  return findings_.failures();
}

// --- the tree

void Swarm::build() {
  plan_ = make_plan(network_);
  if (findings_.is_verbose())
    std::printf("seed %lu\n%s", static_cast<unsigned long>(seed_), plan_.to_string().c_str());
  ledger_.keeps_order = plan_.has_single_routes;
  crashed_.assign(plan_.nodes.size(), false);
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) {
    Node& node = network_.add(plan_.nodes[i].setup);
    node.on_arrival = [this](Node&, core::ClientId, Arrival&& arrival) {
      ledger_.on_arrival(arrival);
    };
    const std::uint64_t count = network_.random(3) + (i == 0 ? 1 : 0);
    for (std::uint32_t c = 0; c < count; ++c) {
      Client client{.node = i, .name = node.setup().name + "/" + std::to_string(c)};
      const std::uint64_t mailboxes = 1 + network_.random(3);
      for (std::uint32_t m = 0; m < mailboxes; ++m)
        client.mailboxes.push_back(Address::of({.system = node.setup().system,
                                                .class_id = 0x10U + node.setup().id,
                                                .instance = c,
                                                .local = m}));
      clients_.push_back(client);
    }
  }
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i)
    network_.at(now() + within(300ms), [this, i] { start(i); });
  plan_faults(now());
}

void Swarm::start(std::size_t i) {
  if (node(i).alive()) return;
  print(node(i).setup().name + " starts at " + node(i).address().to_string());
  node(i).start(now());
  for (Client& client : clients_)
    if (client.node == i) attach(client);
}

void Swarm::attach(Client& client) {
  if (!node(client.node).alive()) return;
  client.id = node(client.node).add_client(now(), client.name);
  for (const Address address : client.mailboxes) {
    if (!node(client.node).add_mailbox(now(), client.id, address))
      fail("mailbox refused: " + address.to_string());
  }
}

// --- trouble

void Swarm::plan_trouble(Duration span) {
  const Troubles& t = plan_.troubles;
  for (std::uint64_t n = network_.random(4); n > 0; --n) plan_faults(now() + within(span));
  if (t.crashes)
    for (std::uint64_t n = 1 + network_.random(3); n > 0; --n) plan_crash(now() + within(span));
  if (t.partitions)
    for (std::uint64_t n = 1 + network_.random(3); n > 0; --n)
      plan_partition(now() + within(span), span);
  if (t.half_cuts) plan_half_cuts(span);
  if (t.moves)
    for (std::uint64_t n = 1 + network_.random(2); n > 0; --n) plan_move(now() + within(span));
  if (t.churn)
    for (std::uint64_t n = 1 + network_.random(6); n > 0; --n) plan_churn(now() + within(span));
  if (t.wall_jumps)
    network_.at(now() + within(span),
                [this] { node(network_.random(plan_.nodes.size())).jump_wall(within(48h) - 24h); });
}

void Swarm::plan_faults(Time when) {
  network_.at(when, [this] {
    if (healed_) return;
    for (const PlannedNode& from : plan_.nodes) {
      for (const PlannedNode& to : plan_.nodes) {
        if (&from != &to) set_faults(from.setup.name, to.setup.name);
      }
    }
  });
}

void Swarm::set_faults(const std::string& from, const std::string& to) {
  network_.set_faults(from, to, make_faults(network_, plan_.troubles));
  if (plan_.troubles.dds)
    network_.set_faults(from, to, make_dds_faults(network_, plan_.troubles), PathKind::kDds);
}

void Swarm::plan_crash(Time when) {
  const std::size_t i = network_.random(plan_.nodes.size());
  const Duration away = network_.random(2) == 0 ? within(20ms) : within(3s);
  network_.at(when, [this, i, away] {
    if (!node(i).alive() || healed_) return;
    print(node(i).setup().name + " crashes");
    node(i).kill();
    crashed_[i] = true;
    for (Client& client : clients_)
      if (client.node == i) client.id = core::kNoClient;
    network_.at(now() + away, [this, i] { start(i); });
  });
}

void Swarm::plan_partition(Time when, Duration span) {
  const std::size_t a = network_.random(plan_.nodes.size());
  const PlannedNode& planned = plan_.nodes[a];
  if (planned.supers.empty() && planned.peers.empty()) return;
  const std::size_t b = planned.supers.empty() ? planned.peers.front() : planned.supers.front();
  const bool one_way = network_.random(4) == 0;
  const Duration length = 100ms + (network_.random(3) == 0 ? within(20s) : within(span));
  const std::uint64_t dice = plan_.troubles.dds ? network_.random(3) : 0;
  network_.at(when, [this, a, b, one_way, length, dice] {
    if (dice != 2) cut(a, b, PathKind::kUdp, one_way, length);
    if (dice != 0) cut(a, b, PathKind::kDds, one_way, length);
  });
}

void Swarm::cut(std::size_t a, std::size_t b, PathKind kind, bool one_way, Duration length) {
  if (healed_) return;
  const std::string from = node(a).setup().name;
  const std::string to = node(b).setup().name;
  const std::string over = " over " + std::string(name(kind));
  print(from + (one_way ? " -> " : " <-> ") + to + over + " cut");
  one_way ? network_.cut_one_way(from, to, true, kind) : network_.cut(from, to, true, kind);
  network_.at(now() + length, [this, from, to, over, kind] {
    print(from + " <-> " + to + over + " joined");
    network_.cut(from, to, false, kind);
  });
}

// Cuts the paths of each link one after the other, so that one always works and is known to work.
void Swarm::plan_half_cuts(Duration span) {
  for (const auto& [lower, upper] : plan_.with_two_paths) {
    for (Time when = now() + within(span); when < now() + span; when += 3s) {
      const std::size_t a = network_.random(2) == 0 ? lower : upper;
      const std::size_t b = a == lower ? upper : lower;
      const PathKind kind = network_.random(2) == 0 ? PathKind::kUdp : PathKind::kDds;
      const bool one_way = network_.random(2) == 0;
      const Duration length = within(1500ms);
      network_.at(when, [this, a, b, kind, one_way, length] { cut(a, b, kind, one_way, length); });
    }
  }
}

void Swarm::plan_move(Time when) {
  const std::size_t i = network_.random(plan_.nodes.size());
  const Duration known_after = within(500ms);
  network_.at(when, [this, i, known_after] {
    if (healed_) return;
    const NetAddress to = address_of(1000 + moves_++);
    print(node(i).setup().name + " moves to " + to.to_string());
    network_.move(node(i), to, known_after);
    if (plan_.troubles.dds && node(i).alive()) network_.announce(node(i));
  });
}

void Swarm::plan_churn(Time when) {
  if (clients_.empty()) return;
  const std::size_t i = network_.random(clients_.size());
  const Duration away = within(1s);
  network_.at(when, [this, i, away] {
    Client& client = clients_[i];
    if (!client.id || healed_) return;
    print(client.name + " leaves");
    node(client.node).remove_client(now(), std::exchange(client.id, core::kNoClient));
    network_.at(now() + away, [this, i] {
      if (clients_[i].id || !node(clients_[i].node).alive()) return;
      print(clients_[i].name + " reconnects");
      attach(clients_[i]);
    });
  });
}

void Swarm::heal() {
  print("all faults end");
  healed_ = true;
  network_.set_faults({.delay = 100us});
  for (std::size_t i = 0; i < plan_.nodes.size(); ++i) start(i);
  for (Client& client : clients_)
    if (!client.id) attach(client);
}

// --- traffic

void Swarm::plan_traffic(Duration span, std::uint64_t messages) {
  for (std::uint64_t n = 0; n < messages; ++n) {
    // Some come together.
    const Time when = now() + within(span);
    for (std::uint64_t burst = network_.random(8) == 0 ? 5 : 1; burst > 0; --burst)
      network_.at(when, [this] { send_something(); });
  }
}

void Swarm::send_something() {
  if (clients_.empty()) return;
  Client& from = clients_[network_.random(clients_.size())];
  Client& to = clients_[network_.random(clients_.size())];
  if (!from.id) return;
  const auto one_of = [&](const std::vector<Address>& all) {
    return all[network_.random(all.size())];
  };
  const bool sample = plan_.troubles.samples && network_.random(3) == 0;
  // A command of a class, whose body is nobody's affair, or an answer.
  Header header{.type = static_cast<std::int8_t>(network_.random(2) == 0 ? 21 : -7),
                .priority = static_cast<std::uint8_t>(network_.random(256))};
  if (sample) header.flags |= flag::kStream, header.type = type::kData;
  std::size_t size = network_.random(64);
  const std::uint64_t kind = network_.random(100);
  if (kind >= 50) size = network_.random(1400);
  if (kind >= 80) size = network_.random(20'000);
  if (kind >= 95) size = network_.random(300'000);
  if (kind >= 97 && plan_.troubles.large) size = 2'000'000;
  send(from, one_of(from.mailboxes), to, one_of(to.mailboxes), header, size);
}

void Swarm::send(Client& from, Address src, Client& to, Address dest, Header header,
                 std::size_t size) {
  header.src = src;
  header.dest = dest;
  std::vector<std::byte> body;
  const std::size_t number =
      ledger_.add({.header = header, .from = from.node, .to = to.node, .at = now()}, size, body);
  header = ledger_.entries()[number].header;
  const core::Outcome outcome = node(from.node).send(now(), from.id, header, body);
  ledger_.set_outcome(number, outcome);
  if (findings_.is_verbose()) print("send " + Ledger::describe(ledger_.entries()[number]));
}

}  // namespace tims::sim

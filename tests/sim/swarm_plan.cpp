#include "tests/sim/swarm_plan.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tims::sim {
namespace {

using link::PathKind;

Troubles make_troubles(SimulatedNetwork& network) {
  const auto coin = [&] { return network.random(2) == 0; };
  const auto rare = [&] { return network.random(4) == 0; };
  Troubles t;
  for (bool* one : {&t.loss, &t.duplicates, &t.reordering, &t.delay, &t.jitter, &t.samples})
    *one = coin();
  for (bool* one : {&t.rates, &t.mtus, &t.partitions, &t.crashes, &t.moves, &t.churn, &t.wall_jumps,
                    &t.small_queues, &t.short_lifetimes, &t.little_memory})
    *one = rare();
  t.large = network.random(16) == 0 && !t.little_memory;
  t.dds = network.random(3) == 0;
  t.half_cuts = t.dds && coin();
  if (t.half_cuts) t.partitions = t.moves = false;
  return t;
}

link::LinkSessionSettings make_session(SimulatedNetwork& network, const Troubles& troubles) {
  link::LinkSessionSettings settings;
  if (troubles.small_queues) settings.queue_bytes_max = (100 + network.random(900)) << 10;
  if (troubles.short_lifetimes)
    settings.lifetime = std::chrono::milliseconds(200 + network.random(3000));
  if (troubles.rates && network.random(2) == 0) settings.rate = 200'000 + network.random(5'000'000);
  return settings;
}

class Planner {
 public:
  Planner(SimulatedNetwork& network, Plan& plan) : network_(network), plan_(plan) {}

  std::size_t add(core::Role role, std::uint8_t system, std::uint8_t id) {
    const std::size_t index = plan_.nodes.size();
    plan_.nodes.push_back({.setup = {.name = name_of(role, system, id),
                                     .role = role,
                                     .system = system,
                                     .id = id,
                                     .block_bytes = memory(32U << 20, 256U << 10),
                                     .message_bytes = memory(32U << 20, 1U << 20),
                                     .message_max = 400'000}});
    if (plan_.troubles.dds) plan_.nodes[index].setup.fleet = "harbour";
    if (role != core::Role::kSubsystem) accept(index, core::LinkKind::kSub);
    return index;
  }
  // `only_one`: `upper` is the only router that fits, so the link can be automatic.
  void connect(std::size_t lower, std::size_t upper, bool only_one) {
    auto settings = super_link(address_of(upper));
    settings.session = make_session(network_, plan_.troubles);
    if (plan_.troubles.dds) settings.paths = paths(only_one && !plan_.troubles.half_cuts);
    if (plan_.troubles.dds && only_one && network_.random(2) == 0) settings.to = link::kAutomatic;
    if (settings.paths.size() == 2) plan_.with_two_paths.push_back({lower, upper});
    plan_.nodes[lower].setup.links.push_back(settings);
    plan_.nodes[lower].supers.push_back(upper);
  }
  void connect_peers(std::size_t a, std::size_t b) {
    auto settings = peer_link(address_of(b));
    if (plan_.troubles.dds) settings.paths = paths(false);
    plan_.nodes[a].setup.links.push_back(settings);
    if (settings.paths.size() == 2) plan_.with_two_paths.push_back({a, b});
    // Sometimes both ends connect.
    if (network_.random(2) == 0) {
      settings.to = address_of(a).to_string();
      plan_.nodes[b].setup.links.push_back(settings);
    } else {
      accept(b, core::LinkKind::kPeer);
    }
    plan_.nodes[a].peers.push_back(b);
    plan_.nodes[b].peers.push_back(a);
  }

 private:
  std::vector<PathKind> paths(bool may_be_one) {
    const std::uint64_t dice = network_.random(may_be_one ? 6 : 4);
    if (dice == 5) return {PathKind::kDds};
    if (dice == 4) return {PathKind::kUdp};
    if (dice == 3) return {PathKind::kDds, PathKind::kUdp};
    return {PathKind::kUdp, PathKind::kDds};
  }
  [[nodiscard]] std::size_t memory(std::size_t much, std::size_t little) const {
    return plan_.troubles.little_memory ? little : much;
  }
  static std::string name_of(core::Role role, std::uint8_t system, std::uint8_t id) {
    if (role == core::Role::kTop) return "top" + std::to_string(id);
    const std::string system_name = "sys" + std::to_string(system);
    return role == core::Role::kSystem ? system_name : system_name + "." + std::to_string(id);
  }
  void accept(std::size_t node, core::LinkKind kind) {
    link::LinkSettings settings{
        .kind = kind, .connects = false, .session = make_session(network_, plan_.troubles)};
    if (plan_.troubles.dds) settings.paths = paths(false);
    plan_.nodes[node].setup.links.push_back(settings);
  }

  SimulatedNetwork& network_;
  Plan& plan_;
};

}  // namespace

std::string Troubles::to_string() const {
  const std::array<std::pair<bool, const char*>, 19> all{{{loss, "loss"},
                                                          {duplicates, "duplicates"},
                                                          {reordering, "reordering"},
                                                          {delay, "delay"},
                                                          {jitter, "jitter"},
                                                          {rates, "rates"},
                                                          {mtus, "mtus"},
                                                          {partitions, "partitions"},
                                                          {crashes, "crashes"},
                                                          {moves, "moves"},
                                                          {churn, "churn"},
                                                          {wall_jumps, "wall_jumps"},
                                                          {large, "large"},
                                                          {samples, "samples"},
                                                          {small_queues, "small_queues"},
                                                          {short_lifetimes, "short_lifetimes"},
                                                          {little_memory, "little_memory"},
                                                          {dds, "dds"},
                                                          {half_cuts, "half_cuts"}}};
  std::string text;
  for (const auto& [is_on, name] : all)
    if (is_on) text += std::string(text.empty() ? "" : " ") + name;
  return text.empty() ? "none" : text;
}

Plan make_plan(SimulatedNetwork& network) {
  Plan plan;
  plan.troubles = make_troubles(network);
  Planner planner(network, plan);
  std::vector<std::size_t> tops;
  const std::uint64_t top_count = network.random(3) == 0 ? 2 : 1;
  for (std::uint8_t i = 1; i <= top_count; ++i) tops.push_back(planner.add(core::Role::kTop, 0, i));
  std::vector<std::size_t> systems;
  const std::uint64_t system_count = 1 + network.random(4);
  const bool two_supers = tops.size() == 2 && network.random(2) == 0;
  for (std::uint8_t s = 1; s <= system_count; ++s) {
    const std::size_t system = planner.add(core::Role::kSystem, s, 1);
    systems.push_back(system);
    const std::size_t first = network.random(tops.size());
    planner.connect(system, tops[first], tops.size() == 1);
    if (two_supers && network.random(2) == 0) {
      planner.connect(system, tops[1 - first], false);
      plan.has_single_routes = false;
    }
    const std::uint64_t below = network.random(4);
    for (std::uint8_t i = 0; i < below; ++i)
      planner.connect(planner.add(core::Role::kSubsystem, s, static_cast<std::uint8_t>(i + 2)),
                      system, true);
  }
  if (tops.size() == 2 && network.random(3) != 0) planner.connect_peers(tops[0], tops[1]);
  if (systems.size() > 1 && network.random(3) == 0) {
    planner.connect_peers(systems[0], systems[1]);
    plan.has_single_routes = false;
  }
  return plan;
}

std::vector<std::size_t> Plan::up_from(std::size_t node) const {
  std::vector<std::size_t> up{node};
  while (!nodes[up.back()].supers.empty()) up.push_back(nodes[up.back()].supers.front());
  return up;
}

bool Plan::is_below(std::size_t node, std::size_t top) const {
  const auto up = up_from(node);
  return std::ranges::find(up, top) != up.end();
}

std::vector<std::size_t> Plan::route(std::size_t from, std::size_t to) const {
  std::vector<std::size_t> passed;
  for (const std::size_t at : up_from(from)) {
    passed.push_back(at);
    std::vector<std::size_t> turns{at};
    turns.insert(turns.end(), nodes[at].peers.begin(), nodes[at].peers.end());
    for (const std::size_t turn : turns) {
      if (!is_below(to, turn)) continue;
      std::vector<std::size_t> down = up_from(to);
      down.erase(std::ranges::find(down, turn) + 1, down.end());
      if (turn == at) down.pop_back();
      passed.insert(passed.end(), down.rbegin(), down.rend());
      return passed;
    }
  }
  return {};
}

std::string Plan::to_string() const {
  std::string text = "troubles: " + troubles.to_string() + "\n";
  for (const PlannedNode& node : nodes) {
    text += node.setup.name;
    for (const std::size_t i : node.supers) text += " -> " + nodes[i].setup.name;
    for (const std::size_t i : node.peers) text += " <-> " + nodes[i].setup.name;
    text += "\n";
  }
  return text;
}

Faults make_faults(SimulatedNetwork& network, const Troubles& troubles) {
  using std::chrono::microseconds;
  Faults faults;
  if (network.random(4) == 0) return faults;
  if (troubles.loss) faults.loss = 0.3 * network.chance() * network.chance();
  if (troubles.duplicates) faults.duplicate = 0.1 * network.chance();
  if (troubles.reordering) faults.reorder = 0.1 * network.chance();
  faults.held_back = microseconds(network.random(20'000));
  faults.delay = microseconds(troubles.delay ? network.random(50'000) : network.random(500));
  if (troubles.jitter) faults.jitter = microseconds(network.random(20'000));
  if (troubles.rates) faults.rate = 125'000 + network.random(6'000'000);
  if (troubles.mtus) faults.mtu = 1200 + network.random(400);
  return faults;
}

Faults make_dds_faults(SimulatedNetwork& network, const Troubles& troubles) {
  using std::chrono::microseconds;
  Faults faults{.delay = microseconds(500 + network.random(20'000))};
  if (troubles.jitter) faults.jitter = microseconds(network.random(20'000));
  if (troubles.rates) faults.rate = 125'000 + network.random(6'000'000);
  if (troubles.loss && network.random(4) == 0)
    faults.loss = 0.3 * network.chance() * network.chance();
  return faults;
}

}  // namespace tims::sim

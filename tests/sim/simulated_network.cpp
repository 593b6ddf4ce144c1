#include "tests/sim/simulated_network.h"

#include <algorithm>
#include <stdexcept>

#include "router/core/random.h"

namespace tims::sim {
namespace {

// Limit of steps at one point in time; beyond it, an endless loop is assumed.
constexpr std::uint64_t kStepsAtOnceMax = 200'000;

// DDS: the time until other routers discover a new one, and until a silent one is reported as gone.
constexpr Duration kDiscovery = std::chrono::milliseconds(200);
constexpr Duration kLease = std::chrono::seconds(3);

using core::next_random;

}  // namespace

NetAddress address_of(std::size_t index) {
  return NetAddress::v4(10, 0, static_cast<std::uint8_t>(index / 250),
                        static_cast<std::uint8_t>(index % 250 + 1), 2010);
}
NetAddress dds_address_of(std::size_t index) {
  return NetAddress::dds(
      {1, 15, static_cast<std::uint8_t>(index >> 8), static_cast<std::uint8_t>(index & 0xFF)});
}
link::LinkSettings super_link(const NetAddress& to) {
  return {.kind = core::LinkKind::kSuper, .connects = true, .to = to.to_string()};
}
link::LinkSettings peer_link(const NetAddress& to) {
  return {.kind = core::LinkKind::kPeer, .connects = true, .to = to.to_string()};
}
link::LinkSettings sub_link(std::optional<std::uint16_t> system) {
  return {.kind = core::LinkKind::kSub, .connects = false, .system = system};
}

Node& SimulatedNetwork::add(const NodeSetup& setup) {
  NodeSetup own = setup;
  if (sealed_ && !own.keys)
    own.keys = {.fleet = 1,
                .name = {.role = own.role, .system = own.system, .id = own.id, .name = own.name}};
  if (judges_ && !own.rules) own.rules.emplace();
  if (own.keys)
    for (link::LinkSettings& settings : own.links) settings.secure = true;
  nodes_.push_back(std::make_unique<Node>(*this, own, nodes_.size(), random()));
  Node& node = *nodes_.back();
  addresses_[node.address_] = addresses_[node.dds_] = &node;
  targets_[node.address_.to_string()] = &node;
  return node;
}

void SimulatedNetwork::report_of(Node& node, Node& to) {
  const link::Announcement announcement = node.announcement();
  at(now_ + kDiscovery, [this, announcement, &to] {
    if (!to.alive()) return;
    to.links().on_announced(now_, announcement);
    to.end_turn(now_);
  });
}

void SimulatedNetwork::announce(Node& node) {
  for (const auto& other : nodes_) {
    const bool same = other->setup().fleet == node.setup().fleet;
    if (!other->alive() || other.get() == &node || !same) continue;
    report_of(node, *other);
    report_of(*other, node);
  }
}

void SimulatedNetwork::forget(Node& node) {
  at(now_ + kLease, [this, dds = node.address(link::PathKind::kDds)] {
    for (const auto& other : nodes_) {
      if (!other->alive() || other->setup().fleet.empty()) continue;
      other->links().on_gone(now_, dds);
      other->end_turn(now_);
    }
  });
}

NetAddress SimulatedNetwork::resolve(const std::string& to) const {
  const auto found = targets_.find(to);
  return found == targets_.end() ? NetAddress{} : found->second->address();
}

void SimulatedNetwork::move(Node& node, const NetAddress& address, Duration known_after) {
  node.move_to(address);
  at(now_ + known_after, [this, address, &node] {
    const auto named = std::ranges::find_if(targets_, [&](auto& t) { return t.second == &node; });
    for (const auto& other : nodes_) {
      if (!other->alive() || node.address() != address) continue;
      other->links().set_target(now_, named->first, address);
      other->end_turn(now_);
    }
  });
}

Node& SimulatedNetwork::node(const std::string& name) {
  for (const auto& node : nodes_) {
    if (node->setup().name == name) return *node;
  }
  throw std::out_of_range("no node " + name);
}

std::uint64_t SimulatedNetwork::random() { return next_random(random_); }

Duration SimulatedNetwork::random(Duration below) {
  const auto count = static_cast<std::uint64_t>(std::max<std::int64_t>(below.count(), 1));
  return Duration(static_cast<std::int64_t>(random(count)));
}

void SimulatedNetwork::at(Time when, std::function<void()> action) {
  events_.push({.at = when, .order = ++order_, .action = std::move(action)});
}

link::FaultInjector& SimulatedNetwork::between(const NetAddress& from, const NetAddress& to) {
  std::shared_ptr<link::FaultInjector>& line = lines_[{from, to}];
  if (!line) {
    line = std::make_shared<link::FaultInjector>(random());
    line->set(faults_);
  }
  return *line;
}

void SimulatedNetwork::share(const std::string& from, const std::string& to,
                             const std::string& other_from, const std::string& other_to) {
  between(node(from).address(), node(to).address());
  lines_[{node(other_from).address(), node(other_to).address()}] =
      lines_[{node(from).address(), node(to).address()}];
}

void SimulatedNetwork::set_faults(const Faults& faults) {
  faults_ = faults;
  for (auto& [key, injector] : lines_) injector->set(faults);
}

void SimulatedNetwork::set_faults(const std::string& from, const std::string& to,
                                  const Faults& faults, link::PathKind kind) {
  between(node(from).address(kind), node(to).address(kind)).set(faults);
}

void SimulatedNetwork::cut_one_way(const std::string& from, const std::string& to, bool blackout,
                                   link::PathKind kind) {
  link::FaultInjector& line = between(node(from).address(kind), node(to).address(kind));
  Faults faults = line.faults();
  faults.blackout = blackout;
  line.set(faults);
}

void SimulatedNetwork::cut(const std::string& a, const std::string& b, bool blackout,
                           link::PathKind kind) {
  cut_one_way(a, b, blackout, kind);
  cut_one_way(b, a, blackout, kind);
}

void SimulatedNetwork::transmit(Node& from, const link::Burst& burst) {
  std::span<const std::byte> rest = burst.bytes;
  bytes_marked_[burst.dscp] += rest.size();
  while (!rest.empty()) {
    const auto one = rest.first(std::min(burst.datagram_size, rest.size()));
    rest = rest.subspan(one.size());
    bytes_sent_[from.setup().name] += one.size() + 28;
    ++datagrams_;
    if (tap && tap(from, burst.to, one)) continue;
    const NetAddress& source = from.address(burst.to.kind);
    const auto copies = between(source, burst.to).send(now_, one.size());
    for (std::size_t i = 0; i < copies.count; ++i) {
      events_.push({.at = copies.at[i],
                    .order = ++order_,
                    .from = source,
                    .to = burst.to,
                    .bytes = {one.begin(), one.end()}});
    }
  }
}

void SimulatedNetwork::inject(const NetAddress& from, const NetAddress& to,
                              std::span<const std::byte> bytes) {
  events_.push({.at = now_,
                .order = ++order_,
                .from = from,
                .to = to,
                .bytes = {bytes.begin(), bytes.end()}});
}

void SimulatedNetwork::schedule(Node& node) {
  const Time at = node.next_timeout();
  if (at >= node.scheduled_) return;
  node.scheduled_ = at;
  timeouts_.push({at, ++order_, &node});
}

// Runs the earliest timeout, unless its node has postponed it since it was queued.
bool SimulatedNetwork::step_timeout() {
  Node& node = *timeouts_.top().node;
  const Time at = timeouts_.top().at;
  timeouts_.pop();
  if (at != node.scheduled_) return false;
  node.scheduled_ = kNever;
  if (!node.alive()) return false;
  if (node.next_timeout() > at) {
    schedule(node);
    return false;
  }
  now_ = std::max(now_, at);
  node.on_timeout(now_);
  return true;
}

void SimulatedNetwork::check_progress() {
  ++steps_;
  if (++steps_now_ > kStepsAtOnceMax)
    throw std::runtime_error("endless loop: the simulated clock does not advance, seed " +
                             std::to_string(seed_));
}

bool SimulatedNetwork::step(Time limit) {
  const Time event_at = events_.empty() ? kNever : events_.top().at;
  const Time timeout_at = timeouts_.empty() ? kNever : timeouts_.top().at;
  const Time next = std::min(event_at, timeout_at);
  if (next > limit) {
    if (limit > now_) steps_now_ = 0;
    now_ = std::max(now_, limit);
    return false;
  }
  if (next > now_) steps_now_ = 0;
  check_progress();
  if (timeout_at < event_at) return step_timeout(), true;
  now_ = std::max(now_, next);
  Event event = std::move(const_cast<Event&>(events_.top()));
  events_.pop();
  if (event.action) {
    event.action();
    return true;
  }
  const auto to = addresses_.find(event.to);
  if (to != addresses_.end()) to->second->on_datagram(now_, event.from, event.bytes);
  return true;
}

void SimulatedNetwork::run_for(Duration time) {
  const Time end = now_ + time;
  while (step(end)) {
  }
}

bool SimulatedNetwork::run_until(const std::function<bool()>& condition, Duration limit) {
  const Time end = now_ + limit;
  while (!condition()) {
    if (!step(end)) return condition();
  }
  return true;
}

}  // namespace tims::sim

#include "tests/sim/world.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>

#include <sys/mman.h>

#include "router/core/random.h"
#include "wire/header.h"

namespace tims::sim {
namespace {

// So much may happen at one moment, or somebody goes round in a circle.
constexpr std::uint64_t kStepsAtOnceMax = 200'000;

// Of DDS: so long until others hear of a router, and until a silent one is gone.
constexpr Duration kDiscovery = std::chrono::milliseconds(200);
constexpr Duration kLease = std::chrono::seconds(3);

using core::next_random;

link::Identity identity(const NodeSetup& setup, std::uint64_t epoch) {
  return {.epoch = epoch,
          .role = setup.role,
          .system = setup.system,
          .id = setup.id,
          .name = std::string_view(setup.name),
          .widths = setup.widths,
          .message_max = setup.message_max};
}

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
link::LinkSettings sub_link(std::optional<std::uint8_t> system) {
  return {.kind = core::LinkKind::kSub, .connects = false, .system = system};
}

Memory::Memory(std::size_t size) {
  void* pages = ::mmap(nullptr, size, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pages == MAP_FAILED) throw std::bad_alloc();
  bytes_ = {static_cast<std::byte*>(pages), size};
}
Memory::~Memory() { ::munmap(bytes_.data(), bytes_.size()); }

// --- a node

Node::Running::Running(Node& node, std::uint64_t epoch)
    : blocks(node.setup_.block_bytes),
      messages(node.setup_.message_bytes),
      pool(blocks.bytes()),
      memory(messages.bytes()),
      router({.address = identity(node.setup_, epoch).address(),
              .widths = node.setup_.widths,
              .role = node.setup_.role,
              .epoch = static_cast<std::uint32_t>(epoch),
              .clients_max = 8192,
              .mailboxes_per_client_max = 1U << 20},
             {epoch, ~epoch}, node),
      links(router, pool, memory,
            {.self = identity(node.setup_, epoch),
             .seed = next_random(node.random_),
             .links_max = node.setup_.links_max}) {}

Node::Node(World& world, const NodeSetup& setup, std::size_t index, std::uint64_t seed)
    : world_(world),
      setup_(setup),
      address_(address_of(index)),
      dds_(dds_address_of(world.participants_++)),
      random_(seed) {}

void Node::start(Time now) {
  now_ = now;
  running_ = std::make_unique<Running>(*this, next_random(random_));
  running_->links.configure(now, setup_.links);
  for (const link::LinkSettings& settings : setup_.links) {
    if (!settings.connects) continue;
    const NetAddress target = world_.resolve(settings.to);
    if (target) running_->links.set_target(now, settings.to, target);
  }
  end_turn(now);
  if (!setup_.fleet.empty()) world_.announce(*this);
}

link::Announcement Node::announcement() const {
  return {.fleet = std::string_view(setup_.fleet),
          .who = running_->links.self(),
          .dds = dds_,
          .udp = {address_}};
}

void Node::kill() {
  if (before_kill) before_kill(*this);
  if (!setup_.fleet.empty()) world_.forget(*this);
  // Its next life has another participant.
  world_.addresses_.erase(dds_);
  dds_ = dds_address_of(world_.participants_++);
  world_.addresses_[dds_] = this;
  for (std::size_t c = 0; c < core::kClasses; ++c) lost_[c] = lost(c);
  running_.reset();
}

void Node::move_to(const NetAddress& address) {
  world_.addresses_.erase(address_);
  address_ = address;
  world_.addresses_[address] = this;
}

std::uint64_t Node::lost(std::size_t message_class) const {
  std::uint64_t sum = lost_[message_class];
  if (!alive()) return sum;
  const core::MessageCounters& counters = running_->router.messages();
  for (const auto outcome :
       {core::Outcome::kQueueFull, core::Outcome::kQueueReplaced, core::Outcome::kExpired,
        core::Outcome::kLinkReset, core::Outcome::kNoRoute, core::Outcome::kWouldReturn,
        core::Outcome::kClientGone, core::Outcome::kTooBig}) {
    sum += counters.of(core::PortKind::kLink, message_class, outcome).messages;
  }
  return sum;
}

std::size_t Node::memory_in_use() const {
  return running_->pool.used() * core::BlockPool::kBlockSize + running_->memory.used_bytes();
}

core::ClientId Node::add_client(Time now, const std::string& name) {
  // One of ours: flags of original programs (TCP) mean nothing beyond their router.
  return router().connect(now,
                          {.port = core::PortKind::kWebSocket, .name = std::string_view(name)});
}

void Node::remove_client(Time now, core::ClientId client) {
  router().disconnect(now, client, core::CloseReason::kPeerClosed);
  end_turn(now);
}

bool Node::add_mailbox(Time now, core::ClientId client, Address address) {
  const auto result = router().register_mailbox(now, client, address);
  end_turn(now);
  return result.status == core::Registration::Status::kOk;
}

core::Outcome Node::send(Time now, core::ClientId client, Header header,
                         std::span<const std::byte> body) {
  now_ = now;
  running_->links.set_now(now);
  std::vector<std::byte> bytes(kHeaderSize + body.size());
  header.length = static_cast<std::uint32_t>(bytes.size());
  wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
  std::ranges::copy(body, bytes.begin() + kHeaderSize);
  core::Message message{.header = header, .bytes = bytes};
  const core::Outcome outcome = router().on_message(now, client, message);
  end_turn(now);
  return outcome;
}

core::Outcome Node::deliver(const core::Receiver& to, const core::Message& message) {
  if (to.port == core::PortKind::kLink) return running_->links.deliver(to.token, message);
  const auto body = message.body();
  arrived(to.client, {now_, message.header, {body.begin(), body.end()}, message.hops});
  return core::Outcome::kDelivered;
}

void Node::arrived(core::ClientId client, Arrival&& arrival) {
  if (on_arrival) return on_arrival(*this, client, std::move(arrival));
  running_->arrivals[client.value].push_back(std::move(arrival));
}

void Node::reply(const core::Receiver& to, const Header& header) {
  if (to.port == core::PortKind::kLink) return running_->links.reply(to.token, header);
  arrived(to.client, {now_, header, {}});
}

void Node::on_datagram(Time now, const NetAddress& from, std::vector<std::byte>& bytes) {
  now_ = now;
  running_->links.on_datagram(now, from, bytes);
  end_turn(now);
}

void Node::on_timeout(Time now) {
  now_ = now;
  running_->links.on_timeout(now);
  end_turn(now);
}

Time Node::next_timeout() const { return running_ ? running_->links.next_timeout() : kNever; }

void Node::end_turn(Time now) {
  running_->links.set_wall(wall_.count());
  do {
    running_->links.flush(now, [this](const link::Train& train) {
      world_.transmit(*this, train);
      return true;
    });
  } while (running_->links.has_something_to_send());
  running_->links.release();
  world_.schedule(*this);
}

// --- the world

Node& World::add(const NodeSetup& setup) {
  nodes_.push_back(std::make_unique<Node>(*this, setup, nodes_.size(), random()));
  Node& node = *nodes_.back();
  addresses_[node.address_] = addresses_[node.dds_] = &node;
  targets_[node.address_.to_string()] = &node;
  return node;
}

void World::tell_of(Node& node, Node& to) {
  const link::Announcement said = node.announcement();
  at(now_ + kDiscovery, [this, said, &to] {
    if (!to.alive()) return;
    to.links().on_announced(now_, said);
    to.end_turn(now_);
  });
}

void World::announce(Node& node) {
  for (const auto& other : nodes_) {
    const bool same = other->setup().fleet == node.setup().fleet;
    if (!other->alive() || other.get() == &node || !same) continue;
    tell_of(node, *other);
    tell_of(*other, node);
  }
}

void World::forget(Node& node) {
  at(now_ + kLease, [this, dds = node.address(link::PathKind::kDds)] {
    for (const auto& other : nodes_) {
      if (!other->alive() || other->setup().fleet.empty()) continue;
      other->links().on_gone(now_, dds);
      other->end_turn(now_);
    }
  });
}

NetAddress World::resolve(const std::string& to) const {
  const auto found = targets_.find(to);
  return found == targets_.end() ? NetAddress{} : found->second->address();
}

void World::move(Node& node, const NetAddress& address, Duration known_after) {
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

Node& World::node(const std::string& name) {
  for (const auto& node : nodes_) {
    if (node->setup().name == name) return *node;
  }
  throw std::out_of_range("no node " + name);
}

std::uint64_t World::random() { return next_random(random_); }

void World::at(Time when, std::function<void()> action) {
  events_.push({.at = when, .order = ++order_, .action = std::move(action)});
}

link::Impairment& World::between(const NetAddress& from, const NetAddress& to) {
  std::shared_ptr<link::Impairment>& line = network_[{from, to}];
  if (!line) {
    line = std::make_shared<link::Impairment>(random());
    line->set(faults_);
  }
  return *line;
}

void World::share(const std::string& from, const std::string& to, const std::string& other_from,
                  const std::string& other_to) {
  between(node(from).address(), node(to).address());
  network_[{node(other_from).address(), node(other_to).address()}] =
      network_[{node(from).address(), node(to).address()}];
}

void World::set_faults(const Faults& faults) {
  faults_ = faults;
  for (auto& [key, impairment] : network_) impairment->set(faults);
}

void World::set_faults(const std::string& from, const std::string& to, const Faults& faults,
                       link::PathKind kind) {
  between(node(from).address(kind), node(to).address(kind)).set(faults);
}

void World::cut_one_way(const std::string& from, const std::string& to, bool blackout,
                        link::PathKind kind) {
  link::Impairment& line = between(node(from).address(kind), node(to).address(kind));
  Faults faults = line.faults();
  faults.blackout = blackout;
  line.set(faults);
}

void World::cut(const std::string& a, const std::string& b, bool blackout, link::PathKind kind) {
  cut_one_way(a, b, blackout, kind);
  cut_one_way(b, a, blackout, kind);
}

void World::transmit(Node& from, const link::Train& train) {
  std::span<const std::byte> rest = train.bytes;
  bytes_marked_[train.dscp] += rest.size();
  while (!rest.empty()) {
    const auto one = rest.first(std::min(train.datagram_size, rest.size()));
    rest = rest.subspan(one.size());
    bytes_sent_[from.setup().name] += one.size() + 28;
    ++datagrams_;
    if (tap && tap(from, train.to, one)) continue;
    const NetAddress& source = from.address(train.to.kind);
    const auto fate = between(source, train.to).send(now_, one.size());
    for (std::size_t i = 0; i < fate.count; ++i) {
      events_.push({.at = fate.at[i],
                    .order = ++order_,
                    .from = source,
                    .to = train.to,
                    .bytes = {one.begin(), one.end()}});
    }
  }
}

void World::inject(const NetAddress& from, const NetAddress& to, std::span<const std::byte> bytes) {
  events_.push({.at = now_,
                .order = ++order_,
                .from = from,
                .to = to,
                .bytes = {bytes.begin(), bytes.end()}});
}

void World::schedule(Node& node) {
  const Time at = node.next_timeout();
  if (at >= node.scheduled_) return;
  node.scheduled_ = at;
  timeouts_.push({at, ++order_, &node});
}

// The first of the timeouts, which may have become a later one meanwhile.
bool World::step_timeout() {
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

void World::check_progress() {
  ++steps_;
  if (++steps_now_ > kStepsAtOnceMax)
    throw std::runtime_error("the world goes round in a circle, seed " + std::to_string(seed_));
}

bool World::step(Time limit) {
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
  if (to != addresses_.end() && to->second->alive())
    to->second->on_datagram(now_, event.from, event.bytes);
  return true;
}

void World::run_for(Duration time) {
  const Time end = now_ + time;
  while (step(end)) {
  }
}

bool World::run_until(const std::function<bool()>& condition, Duration limit) {
  const Time end = now_ + limit;
  while (!condition()) {
    if (!step(end)) return condition();
  }
  return true;
}

}  // namespace tims::sim

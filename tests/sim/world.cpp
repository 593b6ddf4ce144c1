#include "tests/sim/world.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>

#include <sys/mman.h>

#include "wire/header.h"

namespace tims::sim {
namespace {

constexpr std::size_t kBlockBytes = 48 << 20;
constexpr std::size_t kMessageBytes = 16 << 20;

std::uint64_t next_random(std::uint64_t& state) {
  std::uint64_t z = state += 0x9E3779B97F4A7C15U;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9U;
  z = (z ^ z >> 27) * 0x94D049BB133111EBU;
  return z ^ z >> 31;
}

link::Identity identity(const NodeSetup& setup, std::uint64_t epoch) {
  return {.epoch = epoch,
          .role = setup.role,
          .system = setup.system,
          .id = setup.id,
          .name = std::string_view(setup.name),
          .widths = setup.widths,
          .message_max = 8U << 20};
}

}  // namespace

NetAddress address_of(std::size_t index) {
  return NetAddress::v4(10, 0, static_cast<std::uint8_t>(index / 250),
                        static_cast<std::uint8_t>(index % 250 + 1), 2010);
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
    : blocks(kBlockBytes),
      messages(kMessageBytes),
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
            {.self = identity(node.setup_, epoch), .seed = next_random(node.random_)}) {}

Node::Node(World& world, const NodeSetup& setup, const NetAddress& address, std::uint64_t seed)
    : world_(world), setup_(setup), address_(address), random_(seed) {}

void Node::start(Time now) {
  now_ = now;
  running_ = std::make_unique<Running>(*this, next_random(random_));
  running_->links.configure(now, setup_.links);
  for (const link::LinkSettings& settings : setup_.links) {
    if (!settings.connects) continue;
    for (std::size_t i = 0; i < 2000; ++i) {
      if (address_of(i).to_string() == settings.to)
        running_->links.set_target(now, settings.to, address_of(i));
    }
  }
  end_turn(now);
}

void Node::kill() { running_.reset(); }

std::size_t Node::memory_in_use() const {
  return running_->pool.used() * core::BlockPool::kBlockSize + running_->memory.used_bytes();
}

core::ClientId Node::add_client(Time now, const std::string& name) {
  return router().connect(now, {.port = core::PortKind::kTcp, .name = std::string_view(name)});
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
  running_->arrivals[to.client.value].push_back({now_, message.header, {body.begin(), body.end()}});
  return core::Outcome::kDelivered;
}

void Node::reply(const core::Receiver& to, const Header& header) {
  if (to.port == core::PortKind::kLink) return running_->links.reply(to.token, header);
  running_->arrivals[to.client.value].push_back({now_, header, {}});
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
  running_->links.set_wall(static_cast<std::int64_t>(1'700'000'000) * 1'000'000'000);
  do {
    running_->links.flush(now, [this](const link::Train& train) {
      world_.transmit(*this, train);
      return true;
    });
  } while (running_->links.has_something_to_send());
  running_->links.release();
}

// --- the world

Node& World::add(const NodeSetup& setup) {
  nodes_.push_back(std::make_unique<Node>(*this, setup, address_of(nodes_.size()), random()));
  return *nodes_.back();
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

Node* World::at_address(const NetAddress& address) {
  for (const auto& node : nodes_) {
    if (node->address() == address) return node.get();
  }
  return nullptr;
}

link::Impairment& World::between(const NetAddress& from, const NetAddress& to) {
  const auto [place, added] = network_.try_emplace({from, to}, link::Impairment(random()));
  if (added) place->second.set(faults_);
  return place->second;
}

void World::set_faults(const Faults& faults) {
  faults_ = faults;
  for (auto& [key, impairment] : network_) impairment.set(faults);
}

void World::set_faults(const std::string& from, const std::string& to, const Faults& faults) {
  between(node(from).address(), node(to).address()).set(faults);
}

void World::cut(const std::string& a, const std::string& b, bool blackout) {
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
    link::Impairment& line = between(node(from).address(), node(to).address());
    Faults faults = line.faults();
    faults.blackout = blackout;
    line.set(faults);
  }
}

void World::transmit(Node& from, const link::Train& train) {
  std::span<const std::byte> rest = train.bytes;
  while (!rest.empty()) {
    const auto one = rest.first(std::min(train.datagram_size, rest.size()));
    rest = rest.subspan(one.size());
    bytes_sent_[from.setup().name] += one.size() + 28;
    ++datagrams_;
    if (tap && tap(from, train.to, one)) continue;
    const auto fate = between(from.address(), train.to).send(now_, one.size());
    for (std::size_t i = 0; i < fate.count; ++i) {
      events_.push({.at = fate.at[i],
                    .order = ++order_,
                    .from = from.address(),
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

bool World::step(Time limit) {
  Time next = events_.empty() ? kNever : events_.top().at;
  Node* timer = nullptr;
  for (const auto& node : nodes_) {
    if (!node->alive() || node->next_timeout() >= next) continue;
    next = node->next_timeout();
    timer = node.get();
  }
  if (next > limit) {
    now_ = std::max(now_, limit);
    return false;
  }
  now_ = std::max(now_, next);
  if (timer != nullptr) {
    timer->on_timeout(now_);
    return true;
  }
  Event event = std::move(const_cast<Event&>(events_.top()));
  events_.pop();
  if (event.action) {
    event.action();
  } else if (Node* to = at_address(event.to); to != nullptr && to->alive()) {
    to->on_datagram(now_, event.from, event.bytes);
  }
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

// Node: one host of the simulated network.
#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include <sys/mman.h>

#include "router/core/random.h"
#include "router/io/rights.h"
#include "tests/sim/simulated_network.h"
#include "wire/header.h"

namespace tims::sim {
namespace {

using core::next_random;

constexpr std::size_t kPlaces = 32;                            // for messages being reassembled
constexpr Duration kListTime = std::chrono::milliseconds(30);  // verified and on the disk

link::Identity identity(const NodeSetup& setup, std::uint64_t epoch) {
  return {.epoch = epoch,
          .role = setup.role,
          .system = setup.system,
          .id = setup.id,
          .name = std::string_view(setup.name),
          .widths = setup.widths,
          .message_max = setup.message_max,
          .classes = setup.classes.at(setup.widths)};
}

policy::Policy compiled(const policy::PolicyText& rules, const AddressWidths& widths) {
  std::vector<policy::Problem> problems;
  auto policy = policy::Policy::compile(rules, widths, problems);
  if (!policy) throw std::invalid_argument(problems.front().text);
  return std::move(*policy);
}

}  // namespace

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
      messages(kPlaces * link::MessageMemory::place_bytes(node.setup_.message_max)),
      pool(blocks.bytes()),
      memory(messages.bytes(), node.setup_.message_max, node.setup_.message_bytes),
      router({.address = identity(node.setup_, epoch).address(),
              .widths = node.setup_.widths,
              .classes = node.setup_.classes,
              .role = node.setup_.role,
              .epoch = static_cast<std::uint32_t>(epoch),
              .clients_max = 8192,
              .mailboxes_per_client_max = 1U << 20},
             {epoch, ~epoch}, node),
      handshaker(node.handshaker()),
      links(router, pool, memory,
            {.self = identity(node.setup_, epoch),
             .secret = {next_random(node.random_), core::spread(node.random_)},
             .handshaker = handshaker ? &*handshaker : nullptr,
             .lists = handshaker ? &node : nullptr,
             .links_max = node.setup_.links_max}) {
  if (node.setup_.rules) {
    enforcer.emplace(compiled(*node.setup_.rules, node.setup_.widths), epoch);
    router.judge_by(*enforcer);
  }
  for (const auto port : {core::PortKind::kLocal, core::PortKind::kWebSocket})
    router.attach(port, node);
  router.attach(core::PortKind::kLink, links);
  for (const auto kind : {link::PathKind::kUdp, link::PathKind::kDds})
    links.set_sender(kind, &node);
}

Node::Node(SimulatedNetwork& network, const NodeSetup& setup, std::size_t index, std::uint64_t seed)
    : network_(network),
      setup_(setup),
      address_(address_of(index)),
      dds_(dds_address_of(network.participants_++)),
      random_(seed) {}

void Node::start(Time now) {
  running_ = std::make_unique<Running>(*this, next_random(random_));
  running_->links.configure(now, setup_.links);
  set_targets(now);
  if (list_.number > 0) use_list(now);
  end_turn(now);
  if (!setup_.fleet.empty()) network_.announce(*this);
}

std::vector<std::byte> Node::hand_over(Time now) {
  running_->links.announce_pause(now);
  end_turn(now);
  std::vector<std::byte> state = running_->links.save(now);
  kill();
  keeps_socket_ = true;
  return state;
}

std::optional<std::size_t> Node::start(Time now, std::span<const std::byte> state) {
  const auto former = link::Handover::decode(now, state);
  if (!former) {
    start(now);
    return std::nullopt;
  }
  running_ = std::make_unique<Running>(*this, former->self.epoch);
  running_->links.configure(now, setup_.links);
  const std::size_t restored = running_->links.restore(now, *former);
  set_targets(now);
  if (list_.number > 0) use_list(now);
  end_turn(now);
  return restored;
}

void Node::set_targets(Time now) {
  for (const link::LinkSettings& settings : setup_.links) {
    if (!settings.connects) continue;
    const NetAddress target = network_.resolve(settings.to);
    if (target) running_->links.set_target(now, settings.to, target);
  }
}

// --- its list of the fleet

void Node::put_list(Time now, const std::vector<std::byte>& bytes) {
  // Of another fleet: this node is the attacker's, and passes it on all the same.
  list_ = ToyList::open(bytes, setup_.keys->fleet).value_or(ToyList{.number = ~std::uint64_t{0}});
  list_bytes_ = bytes;
  if (!alive()) return;
  use_list(now);
  end_turn(now);
}

void Node::use_list(Time now) {
  running_->links.use_list(now,
                           {.number = list_.number,
                            .bytes = std::make_shared<const std::vector<std::byte>>(list_bytes_)},
                           [this](const link::PeerName& peer) { return list_.standing(peer); });
}

void Node::renew(Time now, const ToyKeys& keys) {
  setup_.keys = keys;
  running_->handshaker->set_keys(keys);
  running_->links.renew_keys(now);
  end_turn(now);
}

// The result comes a moment later, as that of another thread does.
void Node::check(std::uint64_t transfer, std::uint64_t number, std::string_view,
                 std::vector<std::byte>&& bytes) {
  ++lists_checked_;
  network_.at(network_.now() + kListTime,
              [this, run = runs_, transfer, number, bytes = std::move(bytes)] {
                if (!alive() || run != runs_) return;
                const auto list = ToyList::open(bytes, setup_.keys->fleet);
                const bool good = list && list->number == number;
                running_->links.on_list_checked(network_.now(), transfer, good);
                if (good && number > list_.number) put_list(network_.now(), bytes);
                end_turn(network_.now());
              });
}

// The results of a handshake come a moment later, as those of another thread do.
std::optional<ToyHandshaker> Node::handshaker() {
  if (!setup_.keys) return std::nullopt;
  ++runs_;
  handshakes_until_ = network_.now();
  return std::optional<ToyHandshaker>(
      std::in_place, *setup_.keys, core::spread(random_ + runs_),
      [this, run = runs_](link::HandshakeProgress&& progress) {
        auto shared = std::make_shared<link::HandshakeProgress>(std::move(progress));
        handshakes_until_ = std::max(handshakes_until_, network_.now()) + setup_.handshake_step;
        network_.at(handshakes_until_, [this, run, shared] {
          if (!alive() || run != runs_) return;
          running_->links.on_handshake(network_.now(), std::move(*shared));
          end_turn(network_.now());
        });
      });
}

link::Announcement Node::announcement() const {
  return {.fleet = std::string_view(setup_.fleet),
          .identity = running_->links.self(),
          .dds = dds_,
          .udp = {address_}};
}

void Node::kill() {
  if (before_kill) before_kill(*this);
  keeps_socket_ = false;
  if (!setup_.fleet.empty()) network_.forget(*this);
  // After a restart it is another DDS participant.
  network_.addresses_.erase(dds_);
  dds_ = dds_address_of(network_.participants_++);
  network_.addresses_[dds_] = this;
  for (std::size_t c = 0; c < core::kClasses; ++c) lost_[c] = lost(c);
  running_.reset();
}

void Node::move_to(const NetAddress& address) {
  network_.addresses_.erase(address_);
  address_ = address;
  network_.addresses_[address] = this;
}

std::uint64_t Node::lost(std::size_t message_class) const {
  std::uint64_t sum = lost_[message_class];
  if (!alive()) return sum;
  const core::MessageCounters& counters = running_->router.messages();
  for (const auto outcome :
       {core::Outcome::kQueueFull, core::Outcome::kQueueReplaced, core::Outcome::kExpired,
        core::Outcome::kLinkReset, core::Outcome::kNoRoute, core::Outcome::kWouldReturn,
        core::Outcome::kClientGone, core::Outcome::kTooBig, core::Outcome::kForgedSource}) {
    sum += counters.of(core::PortKind::kLink, message_class, outcome).messages;
  }
  return sum;
}

std::size_t Node::memory_in_use() const {
  return running_->pool.used() * core::BlockPool::kBlockSize + running_->memory.used_bytes();
}

core::ClientId Node::add_client(Time now, const std::string& name, core::PortKind port) {
  return router().connect(now, {.port = port, .name = std::string_view(name)});
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
  std::vector<std::byte> bytes(kHeaderSize + body.size());
  header.length = static_cast<std::uint32_t>(bytes.size());
  wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
  std::ranges::copy(body, bytes.begin() + kHeaderSize);
  core::Message message{.header = header, .bytes = bytes};
  const core::Outcome outcome = router().on_message(now, client, message);
  end_turn(now);
  return outcome;
}

core::Outcome Node::deliver(Time now, const core::Receiver& to, const core::Message& message) {
  const auto body = message.body();
  arrived(to.client, {now, message.header, {body.begin(), body.end()}, message.hops});
  return core::Outcome::kDelivered;
}

void Node::arrived(core::ClientId client, Arrival&& arrival) {
  if (on_arrival) return on_arrival(*this, client, std::move(arrival));
  running_->arrivals[client.value].push_back(std::move(arrival));
}

void Node::admin(Time, core::ClientId, const core::Message& request) {
  questions.emplace_back(io::SentMessage::of(request, router().settings()).body);
}

policy::Right Node::right_of(const core::Message& request) {
  const core::RouterSettings& settings = router().settings();
  return io::asked_of(io::SentMessage::of(request, settings), settings.widths);
}

void Node::reply(Time now, const core::Receiver& to, const Header& header) {
  arrived(to.client, {now, header, {}});
}

bool Node::offer(const link::Burst& burst) {
  network_.transmit(*this, burst);
  return true;
}

void Node::on_datagram(Time now, const NetAddress& from, std::vector<std::byte>& bytes) {
  if (!alive() && !keeps_socket_) return;
  if (!alive() || running_->links.holds_back()) {
    in_socket_.emplace_back(from, std::move(bytes));
    return;
  }
  running_->links.on_datagram(now, from, bytes);
  end_turn(now);
}

void Node::on_timeout(Time now) {
  running_->links.on_timeout(now);
  end_turn(now);
}

Time Node::next_timeout() const { return running_ ? running_->links.next_timeout() : kNever; }

void Node::end_turn(Time now) {
  running_->links.set_wall(wall_.count());
  do {
    running_->router.flush(now);
  } while (running_->links.has_something_to_send());
  running_->links.release();
  network_.schedule(*this);
  if (running_->links.holds_back()) return;
  for (auto& [from, bytes] : std::exchange(in_socket_, {})) on_datagram(now, from, bytes);
}

}  // namespace tims::sim

// A fleet in one process: routers with their links, a network of impairments between them, clients
// with mailboxes, and a clock that jumps from one event to the next. All of it follows from a seed.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <queue>
#include <string>
#include <vector>

#include "router/core/router.h"
#include "router/link/impairment.h"
#include "router/link/links.h"

namespace tims::sim {

using link::Faults;
using link::NetAddress;

struct NodeSetup {
  std::string name{};
  core::Role role = core::Role::kSystem;
  std::uint8_t system = 0;
  std::uint8_t id = 1;
  std::vector<link::LinkSettings> links{};
  AddressWidths widths{};
};

// What a client received.
struct Arrival {
  Time at{};
  Header header{};
  std::vector<std::byte> body{};
};

class World;

// Reserved, and taken from the system only as far as it is touched.
class Memory {
 public:
  explicit Memory(std::size_t size);
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory();

  [[nodiscard]] std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

// One host: a router, its links and its clients. Killed, it forgets everything.
class Node final : private core::Sink {
 public:
  Node(World& world, const NodeSetup& setup, const NetAddress& address, std::uint64_t seed);

  [[nodiscard]] bool alive() const { return running_ != nullptr; }
  void start(Time now);
  void kill();  // as kill -9

  [[nodiscard]] const NodeSetup& setup() const { return setup_; }
  [[nodiscard]] const NetAddress& address() const { return address_; }
  void move_to(const NetAddress& address) { address_ = address; }
  core::Router& router() { return running_->router; }
  link::Links& links() { return running_->links; }
  [[nodiscard]] std::size_t memory_in_use() const;

  // A client with a mailbox. Clients of a killed node are gone with it.
  core::ClientId add_client(Time now, const std::string& name);
  bool add_mailbox(Time now, core::ClientId client, Address address);
  core::Outcome send(Time now, core::ClientId client, Header header,
                     std::span<const std::byte> body = {});
  [[nodiscard]] const std::vector<Arrival>& arrivals(core::ClientId client) {
    return running_->arrivals[client.value];
  }
  std::vector<core::Event> events;  // of all lives
  std::vector<Header> undelivered;  // NOT_AVAILABLE and the like that came to connections

  void on_datagram(Time now, const NetAddress& from, std::vector<std::byte>& bytes);
  void on_timeout(Time now);
  [[nodiscard]] Time next_timeout() const;

 private:
  core::Outcome deliver(const core::Receiver& to, const core::Message& message) override;
  void reply(const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver&, core::CloseReason) override {}
  void admin(core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event& event) override { events.push_back(event); }
  void end_turn(Time now);

  struct Running {
    Running(Node& node, std::uint64_t epoch);
    Memory blocks;
    Memory messages;
    core::BlockPool pool;
    link::MessageMemory memory;
    core::Router router;
    link::Links links;
    std::map<std::uint32_t, std::vector<Arrival>> arrivals;  // by client
  };

  World& world_;
  NodeSetup setup_;
  NetAddress address_;
  std::uint64_t random_;
  Time now_{};
  std::unique_ptr<Running> running_;
};

class World {
 public:
  explicit World(std::uint64_t seed) : seed_(seed), random_(seed) {}

  Node& add(const NodeSetup& setup);  // not started
  [[nodiscard]] std::vector<std::unique_ptr<Node>>& nodes() { return nodes_; }
  Node& node(const std::string& name);

  [[nodiscard]] Time now() const { return now_; }
  // Runs until then, or until `until` says so. False: it did not.
  void run_for(Duration time);
  bool run_until(const std::function<bool()>& condition, Duration limit);
  // Something to be done then.
  void at(Time when, std::function<void()> action);

  // What lies between two nodes, in one direction; ALL between others.
  void set_faults(const Faults& faults);
  void set_faults(const std::string& from, const std::string& to, const Faults& faults);
  void cut(const std::string& a, const std::string& b, bool blackout = true);

  std::uint64_t random();
  std::uint64_t random(std::uint64_t below) { return random() % below; }
  double chance() { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

  // For nodes: a train leaves.
  void transmit(Node& from, const link::Train& train);
  [[nodiscard]] std::uint64_t bytes_sent(const std::string& from) { return bytes_sent_[from]; }
  [[nodiscard]] std::uint64_t datagrams() const { return datagrams_; }
  // Sees every datagram; true: it goes no further.
  std::function<bool(Node& from, const NetAddress& to, std::span<const std::byte>)> tap;
  void inject(const NetAddress& from, const NetAddress& to, std::span<const std::byte> bytes);

 private:
  struct Event {
    Time at{};
    std::uint64_t order = 0;
    NetAddress from{};
    NetAddress to{};
    std::vector<std::byte> bytes{};
    std::function<void()> action{};
    bool operator>(const Event& other) const {
      return at != other.at ? at > other.at : order > other.order;
    }
  };
  bool step(Time limit);
  link::Impairment& between(const NetAddress& from, const NetAddress& to);
  Node* at_address(const NetAddress& address);

  std::uint64_t seed_;
  std::uint64_t random_;
  Time now_{std::chrono::seconds(100)};
  std::uint64_t order_ = 0;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::map<std::pair<NetAddress, NetAddress>, link::Impairment> network_;
  Faults faults_{};
  std::map<std::string, std::uint64_t> bytes_sent_;
  std::uint64_t datagrams_ = 0;
};

// "10.0.0.N:2010" for the Nth node.
NetAddress address_of(std::size_t index);
link::LinkSettings super_link(const NetAddress& to);
link::LinkSettings peer_link(const NetAddress& to);
link::LinkSettings sub_link(std::optional<std::uint8_t> system = {});

}  // namespace tims::sim

// A fleet in one process: routers with their links, an unreliable network between them, clients
// with mailboxes, and a clock that jumps from one event to the next. The seed determines all of it.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <queue>
#include <string>
#include <utility>
#include <vector>

#include "router/core/random.h"
#include "router/core/router.h"
#include "router/link/fault_injection.h"
#include "router/link/links.h"
#include "router/policy/enforcer.h"
#include "tests/sim/toy_keys.h"

namespace tims::sim {

using link::Faults;
using link::NetAddress;

struct NodeSetup {
  std::string name{};
  core::Role role = core::Role::kSystem;
  std::uint16_t system = 0;
  std::uint16_t id = 1;
  std::vector<link::LinkSettings> links{};
  AddressWidths widths{};
  std::size_t block_bytes = 48U << 20;
  std::size_t message_bytes = 64U << 20;
  std::uint32_t message_max = 8U << 20;
  std::uint32_t links_max = 4096;
  std::string fleet{};  // the fleet it announces itself in; empty: none
  core::PriorityClasses classes{};
  // Its links are sealed, unless they say otherwise. Without: the network's.
  std::optional<ToyKeys> keys{};
  // What a step of a handshake takes its thread, one step after the other.
  Duration handshake_step = std::chrono::microseconds(700);
  // Its clients and links are judged by these rules; empty: everything passes.
  std::optional<policy::PolicyText> rules{};
};

// What a client received.
struct Arrival {
  Time at{};
  Header header{};
  std::vector<std::byte> body{};
  std::uint8_t hops = 0;
};

class SimulatedNetwork;

// Reserved address space; the system provides pages only where they are touched.
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

// One host: a router, its links and its clients. A killed node loses all its state.
class Node final : private core::Port,
                   private core::RouterHooks,
                   private link::DatagramSender,
                   private link::ListKeeper {
 public:
  Node(SimulatedNetwork& network, const NodeSetup& setup, std::size_t index, std::uint64_t seed);

  [[nodiscard]] bool alive() const { return running_ != nullptr; }
  void start(Time now);
  void kill();  // as kill -9
  // As an upgrade: ends, and leaves its links to the next run, to which its clients must be added
  // again. Datagrams wait in its socket meanwhile.
  std::vector<std::byte> hand_over(Time now);
  // The number of links that go on; nothing: `state` is none.
  std::optional<std::size_t> start(Time now, std::span<const std::byte> state);

  [[nodiscard]] const NodeSetup& setup() const { return setup_; }
  [[nodiscard]] link::Announcement announcement() const;
  [[nodiscard]] const NetAddress& address() const { return address_; }
  [[nodiscard]] const NetAddress& address(link::PathKind kind) const {
    return kind == link::PathKind::kUdp ? address_ : dds_;
  }
  void move_to(const NetAddress& address);
  void jump_wall(Duration by) { wall_ += by; }
  // Puts a list on its disk, as an authority does, and uses it. Kept over restarts.
  void put_list(Time now, const std::vector<std::byte>& bytes);
  // It has a new certificate.
  void renew(Time now, const ToyKeys& keys);
  [[nodiscard]] std::uint64_t list_number() const { return list_.number; }
  [[nodiscard]] std::size_t lists_checked() const { return lists_checked_; }
  core::Router& router() { return running_->router; }
  link::Links& links() { return running_->links; }
  [[nodiscard]] std::size_t memory_in_use() const;

  // Adds a client, without mailboxes: a program of this host, or a page (kWebSocket), whose sources
  // the router does not refuse. Killing the node removes its clients.
  core::ClientId add_client(Time now, const std::string& name,
                            core::PortKind port = core::PortKind::kLocal);
  bool add_mailbox(Time now, core::ClientId client, Address address);
  core::Outcome send(Time now, core::ClientId client, Header header,
                     std::span<const std::byte> body = {});
  void remove_client(Time now, core::ClientId client);
  [[nodiscard]] const std::vector<Arrival>& arrivals(core::ClientId client) {
    return running_->arrivals[client.value];
  }
  void forget_arrivals(core::ClientId client) { running_->arrivals[client.value].clear(); }
  // If set, it is called for every message a client receives, and arrivals() stays empty.
  std::function<void(Node&, core::ClientId, Arrival&&)> on_arrival;
  std::vector<core::Event> events;  // kept over restarts
  // Questions to this router, and the rules that have denied one here.
  std::vector<std::string> questions;
  std::vector<std::string> denied;
  [[nodiscard]] std::size_t handshakes() const {
    return running_->handshaker ? running_->handshaker->running() : 0;
  }
  // Messages of a class that were accepted and lost, or refused on their route; over restarts.
  [[nodiscard]] std::uint64_t lost(std::size_t message_class) const;
  std::function<void(Node&)> before_kill;

  void on_datagram(Time now, const NetAddress& from, std::vector<std::byte>& bytes);
  void on_timeout(Time now);
  [[nodiscard]] Time next_timeout() const;

 private:
  // core::Port, for its clients
  core::Outcome deliver(Time now, const core::Receiver& to, const core::Message& message) override;
  void reply(Time now, const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver&, core::CloseReason) override {}
  void admin(Time, core::ClientId, const core::Message& request) override;
  policy::Right right_of(const core::Message& request) override;
  void deny_admin(core::ClientId, const core::Message&, std::string_view rule) override {
    denied.emplace_back(rule);
  }
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event& event) override { events.push_back(event); }
  bool offer(const link::Burst& burst) override;
  void check(std::uint64_t transfer, std::uint64_t number, std::string_view from,
             std::vector<std::byte>&& bytes) override;
  void use_list(Time now);
  void set_targets(Time now);
  void arrived(core::ClientId client, Arrival&& arrival);

 public:
  // Sends what direct calls to the router or its links have produced.
  void end_turn(Time now);

 private:
  struct Running {
    Running(Node& node, std::uint64_t epoch);
    Memory blocks;
    Memory messages;
    core::BlockPool pool;
    link::MessageMemory memory;
    std::optional<policy::Enforcer> enforcer;
    core::Router router;
    std::optional<ToyHandshaker> handshaker;
    link::Links links;
    std::map<std::uint32_t, std::vector<Arrival>> arrivals;  // by client
  };

  std::optional<ToyHandshaker> handshaker();

  SimulatedNetwork& network_;
  NodeSetup setup_;
  std::uint64_t runs_ = 0;   // with keys
  Time handshakes_until_{};  // its thread has work
  ToyList list_;
  std::vector<std::byte> list_bytes_;
  std::size_t lists_checked_ = 0;
  NetAddress address_;
  NetAddress dds_;
  std::uint64_t random_;
  Duration wall_ = std::chrono::seconds(1'700'000'000);
  std::array<std::uint64_t, core::kClasses> lost_{};  // before the last restart
  std::unique_ptr<Running> running_;
  bool keeps_socket_ = false;
  std::vector<std::pair<NetAddress, std::vector<std::byte>>> in_socket_;

  friend class SimulatedNetwork;
  Time scheduled_ = kNever;  // its entry in the network's queue of timeouts
};

class SimulatedNetwork {
 public:
  explicit SimulatedNetwork(std::uint64_t seed) : seed_(seed), random_(seed) {}

  Node& add(const NodeSetup& setup);  // not started
  // All nodes added from here on have keys of one fleet.
  void seal_all() { sealed_ = true; }
  // All nodes added from here on judge by the built-in rules, unless they have others.
  void judge_all() { judges_ = true; }
  [[nodiscard]] std::vector<std::unique_ptr<Node>>& nodes() { return nodes_; }
  Node& node(const std::string& name);
  // Announces the node to the other nodes of its fleet, and those to the node.
  void announce(Node& node);
  // The other nodes of the fleet lose it after the lease time.
  void forget(Node& node);
  // The current address of the node that a link's `to` names.
  [[nodiscard]] NetAddress resolve(const std::string& to) const;
  // Changes a node's address; nodes that connect to it learn the new one after `known_after`.
  void move(Node& node, const NetAddress& address, Duration known_after);

  [[nodiscard]] Time now() const { return now_; }
  void run_for(Duration time);
  // Runs until `condition` is true, for at most `limit`. Returns the condition at the end.
  bool run_until(const std::function<bool()>& condition, Duration limit);
  // Calls `action` at that time.
  void at(Time when, std::function<void()> action);

  // Faults of all lines, or of the line from one node to another (one direction).
  void set_faults(const Faults& faults);
  void set_faults(const std::string& from, const std::string& to, const Faults& faults,
                  link::PathKind kind = link::PathKind::kUdp);
  void cut(const std::string& a, const std::string& b, bool blackout = true,
           link::PathKind kind = link::PathKind::kUdp);
  void cut_one_way(const std::string& from, const std::string& to, bool blackout = true,
                   link::PathKind kind = link::PathKind::kUdp);
  // The second pair of nodes shares the line of the first: one radio for both.
  void share(const std::string& from, const std::string& to, const std::string& other_from,
             const std::string& other_to);

  std::uint64_t random();
  std::uint64_t random(std::uint64_t below) { return random() % below; }
  Duration random(Duration below);  // 0 if that is not above 0
  double chance() { return core::next_share(random_); }

  // Called by nodes: sends a burst.
  void transmit(Node& from, const link::Burst& burst);
  [[nodiscard]] std::uint64_t bytes_sent(const std::string& from) { return bytes_sent_[from]; }
  // Bytes sent by all nodes with this DSCP (differentiated services).
  [[nodiscard]] std::uint64_t bytes_marked(std::uint8_t dscp) { return bytes_marked_[dscp]; }
  [[nodiscard]] std::uint64_t datagrams() const { return datagrams_; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  void schedule(Node& node);
  // Called for every datagram; true: the datagram is dropped.
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
  link::FaultInjector& between(const NetAddress& from, const NetAddress& to);
  bool step_timeout();
  void check_progress();
  void report_of(Node& node, Node& to);

  struct Timeout {
    Time at{};
    std::uint64_t order = 0;
    Node* node = nullptr;
    bool operator>(const Timeout& other) const {
      return at != other.at ? at > other.at : order > other.order;
    }
  };
  friend class Node;

  std::uint64_t seed_;
  bool sealed_ = false;
  bool judges_ = false;
  std::uint64_t random_;
  Time now_{std::chrono::seconds(100)};
  std::uint64_t order_ = 0;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::priority_queue<Timeout, std::vector<Timeout>, std::greater<>> timeouts_;
  std::map<NetAddress, Node*> addresses_;
  std::size_t participants_ = 0;          // DDS participants created so far
  std::map<std::string, Node*> targets_;  // by each node's first address
  std::map<std::pair<NetAddress, NetAddress>, std::shared_ptr<link::FaultInjector>> lines_;
  Faults faults_{};
  std::map<std::string, std::uint64_t> bytes_sent_;
  std::map<std::uint8_t, std::uint64_t> bytes_marked_;
  std::uint64_t datagrams_ = 0;
  std::uint64_t steps_ = 0;
  std::uint64_t steps_now_ = 0;  // since the clock last advanced
};

// "10.0.0.N:2010" for the Nth node.
NetAddress address_of(std::size_t index);
NetAddress dds_address_of(std::size_t index);
link::LinkSettings super_link(const NetAddress& to);
link::LinkSettings peer_link(const NetAddress& to);
link::LinkSettings sub_link(std::optional<std::uint16_t> system = {});

}  // namespace tims::sim

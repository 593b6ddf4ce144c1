// Two linked routers and a network controlled by the input: it sends, loses, duplicates, reorders,
// damages and forges datagrams, advances the time, restarts a router, changes its address or
// settings, and takes its link down. Properties: the routers stay within their memory and never
// loop endlessly; without damage, everything that arrives was sent; when the faults end, both
// routers reconnect.
#include <memory>
#include <vector>

#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/small_node.h"
#include "tests/sim/simulated_network.h"

namespace {

using namespace tims;
using namespace std::chrono_literals;

struct Pair : sim::SimulatedNetwork {
  Pair() : SimulatedNetwork(1) {
    base = &add(fuzz::small_node("base", core::Role::kTop, 0, {sim::sub_link()}));
    robot = &add(
        fuzz::small_node("robot", core::Role::kSystem, 1, {sim::super_link(sim::address_of(0))}));
    tap = [this](sim::Node& from, const sim::NetAddress& to, std::span<const std::byte> bytes) {
      if (free) return false;
      held.push_back({from.address(), to, {bytes.begin(), bytes.end()}});
      if (held.size() > 256) held.erase(held.begin());
      return true;
    };
    for (sim::Node* node : {base, robot}) {
      node->on_arrival = [this](sim::Node&, core::ClientId, sim::Arrival&& arrival) {
        check(arrival);
      };
      begin(*node);
    }
  }
  void begin(sim::Node& node) {
    node.start(now());
    client(node) = node.add_client(now(), "client");
    node.add_mailbox(now(), client(node), mailbox(node));
  }
  core::ClientId& client(sim::Node& node) { return clients[&node == base ? 0 : 1]; }
  Address mailbox(sim::Node& node) const {
    return Address(&node == base ? 0x00020000 : 0x01140000);
  }
  sim::Node& other(sim::Node& node) const { return &node == base ? *robot : *base; }

  void send(sim::Node& from, fuzz::Input& in) {
    const auto priority = in.number<std::uint8_t>();
    const std::size_t size = in.number<std::uint16_t>() % 5000;
    Header header{.type = 3,
                  .priority = priority,
                  .seq_nr = static_cast<std::uint8_t>(size),
                  .dest = mailbox(other(from)),
                  .src = mailbox(from)};
    if (priority % 5 == 0) header.flags |= flag::kStream;
    from.send(now(), client(from), header,
              std::vector<std::byte>(size, static_cast<std::byte>(size)));
  }
  // Damaged datagrams may have any header, so only undamaged messages are compared.
  void check(const sim::Arrival& arrival) const {
    if (damaged || arrival.header.type != 3) return;
    for (const std::byte b : arrival.body) fuzz::require(b == std::byte{arrival.header.seq_nr});
    fuzz::require(static_cast<std::uint8_t>(arrival.body.size()) == arrival.header.seq_nr);
  }

  struct Held {
    sim::NetAddress from{};
    sim::NetAddress to{};
    std::vector<std::byte> bytes{};
  };
  void deliver(std::size_t which, bool keep, fuzz::Input& in, std::size_t changes) {
    if (held.empty()) return;
    const auto at = held.begin() + static_cast<std::ptrdiff_t>(which % held.size());
    Held one = *at;
    if (!keep) held.erase(at);
    for (; changes > 0 && !one.bytes.empty(); --changes, damaged = true) {
      const std::size_t place = in.number<std::uint16_t>() % one.bytes.size();
      one.bytes[place] = static_cast<std::byte>(in.number<std::uint8_t>());
    }
    inject(one.from, one.to, one.bytes);
    run_for(0ms);
  }
  void act(fuzz::Input& in) {
    const auto what = in.number<std::uint8_t>();
    sim::Node& node = (what & 0x80) != 0 ? *base : *robot;
    switch (what % 10) {
      case 0:
      case 1:
        return send(node, in);
      case 2:
      case 3:
        return deliver(0, false, in, 0);
      case 4:
        return deliver(in.number<std::uint8_t>(), false, in, 0);
      case 5:
        return deliver(in.number<std::uint8_t>(), true, in, 0);
      case 6:
        return deliver(in.number<std::uint8_t>(), true, in, 1U + what % 3);
      case 7:
        if (!held.empty()) held.erase(held.begin());
        return;
      case 8:
        return run_for(1ms * in.number<std::uint8_t>());
      default:
        if (what % 20 != 9) return interfere(node, in);
        node.kill();
        return begin(node);
    }
  }
  void interfere(sim::Node& node, fuzz::Input& in) {
    const auto what = in.number<std::uint8_t>();
    const unsigned how = what / 4;
    switch (what % 4) {
      case 0:
        return move(node, sim::address_of((&node == base ? 10 : 20) + how % 8), 1ms * how);
      case 1:
        node.links().act(now(), other(node).setup().name, link::Links::Action(how % 3));
        return node.end_turn(now());
      case 2:
        return configure(node, how);
      default:
        // Adds or removes mailboxes.
        const Address address = Address(mailbox(node).raw() + 1 + how % 4);
        if (!node.add_mailbox(now(), client(node), address)) {
          node.router().remove_mailbox(now(), client(node), address);
          node.end_turn(now());
        }
    }
  }
  void configure(sim::Node& node, unsigned how) {
    std::vector<link::LinkSettings> links = node.setup().links;
    link::LinkSettings& settings = links.front();
    if (how % 2 == 1) settings.session.rate = 1000U << how % 8;
    if (how % 3 == 1) settings.session.lifetime = 50ms;
    if (how % 5 == 1) settings.keep_alive = 20ms;
    if (how % 7 == 1) settings.session.queue_bytes_max = 4096;
    if (how % 11 == 1) settings.session.reserve = 50;
    node.links().configure(now(), links);
    node.end_turn(now());
  }
  // Ends all faults.
  void leave_alone() {
    free = true;
    for (sim::Node* node : {base, robot}) {
      node->links().configure(now(), node->setup().links);
      node->links().act(now(), other(*node).setup().name, link::Links::Action::kUp);
      node->end_turn(now());
    }
  }

  sim::Node* base;
  sim::Node* robot;
  std::array<core::ClientId, 2> clients{};
  std::vector<Held> held;
  bool free = false;
  bool damaged = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  Pair pair;
  for (int n = 0; n < 400 && !in.empty(); ++n) pair.act(in);
  pair.leave_alone();
  const auto together = [&] {
    return pair.base->router().find(pair.mailbox(*pair.robot)) != nullptr;
  };
  // A refusal is respected for three seconds. A lane damaged in spite of UDP's checksum is detected
  // by a table that stays wrong.
  fuzz::require(pair.run_until(together, pair.damaged ? 60s : 8s));
  return 0;
}

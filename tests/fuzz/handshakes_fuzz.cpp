// Two routers with keys, and a network that is the attacker's: it loses, repeats, reorders, damages
// and forges datagrams as the input says, begins handshakes from addresses of its own, and lets
// hours pass; the routers restart, also with what the former one has left, and get new
// certificates. Keys and handshakes are those of the simulation. Properties: whatever arrives was
// sent; nobody but the other router has a link, and none without keys; handshakes stay within their
// number; when the attack ends, both routers reconnect.
#include <map>
#include <variant>
#include <vector>

#include "router/link/datagram.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/small_node.h"
#include "tests/sim/simulated_network.h"

namespace {

using namespace tims;
using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

class Attacked : private sim::SimulatedNetwork {
 public:
  Attacked() : SimulatedNetwork(1) {
    seal_all();
    base_ = &add(fuzz::small_node("base", core::Role::kTop, 0, {sim::sub_link()}));
    robot_ = &add(
        fuzz::small_node("robot", core::Role::kSystem, 1, {sim::super_link(sim::address_of(0))}));
    tap = [this](sim::Node& from, const sim::NetAddress& to, std::span<const std::byte> bytes) {
      hear(to, bytes);
      if (free_) return false;
      held_.push_back({from.address(), to, {bytes.begin(), bytes.end()}});
      if (held_.size() > 256) held_.erase(held_.begin());
      return true;
    };
    for (sim::Node* node : {base_, robot_}) {
      node->on_arrival = [](sim::Node&, core::ClientId, sim::Arrival&& arrival) { check(arrival); };
      node->start(now());
      begin(*node);
    }
  }
  void act(fuzz::Input& in) {
    const auto what = in.number<std::uint8_t>();
    sim::Node& node = (what & 0x80) != 0 ? *base_ : *robot_;
    switch (what % 12) {
      case 0:
        send(node, in);
        break;
      case 1:
      case 2:
        deliver(0, false, in, 0);
        break;
      case 3:
        deliver(in.number<std::uint8_t>(), false, in, 0);
        break;
      case 4:
        deliver(in.number<std::uint8_t>(), true, in, 0);
        break;
      case 5:
        deliver(in.number<std::uint8_t>(), true, in, 1U + what % 3);
        break;
      case 6:
        if (!held_.empty()) held_.erase(held_.begin());
        break;
      case 7:
        run_for(1ms * in.number<std::uint8_t>());
        break;
      case 8:
      case 9:
        forge(node, in);
        break;
      case 10:
        restart(node, (what & 0x40) != 0);
        break;
      default:
        (what & 0x40) != 0 ? pass_time(in) : renew(node, in.number<std::uint8_t>());
    }
    check();
  }
  void end() {
    free_ = true;
    fuzz::require(run_until(
        [&] { return base_->router().find(mailbox(*robot_)) != nullptr && is_linked(*robot_); },
        30s));
  }

 private:
  struct Held {
    sim::NetAddress from{};
    sim::NetAddress to{};
    Bytes bytes{};
  };

  void begin(sim::Node& node) {
    client(node) = node.add_client(now(), "client");
    node.add_mailbox(now(), client(node), mailbox(node));
  }
  core::ClientId& client(const sim::Node& node) { return clients_[&node == base_ ? 0 : 1]; }
  Address mailbox(const sim::Node& node) const {
    return Address(&node == base_ ? 0x00020000 : 0x01140000);
  }
  sim::Node& other(const sim::Node& node) const { return &node == base_ ? *robot_ : *base_; }

  void send(sim::Node& from, fuzz::Input& in) {
    const std::size_t size = in.number<std::uint16_t>() % 3000;
    from.send(now(), client(from),
              {.type = 3,
               .priority = static_cast<std::uint8_t>(size),
               .seq_nr = static_cast<std::uint8_t>(size),
               .dest = mailbox(other(from)),
               .src = mailbox(from)},
              Bytes(size, static_cast<std::byte>(size)));
  }
  static void check(const sim::Arrival& arrival) {
    if (arrival.header.type != 3) return;  // NOT_AVAILABLE
    for (const std::byte b : arrival.body) fuzz::require(b == std::byte{arrival.header.seq_nr});
    fuzz::require(static_cast<std::uint8_t>(arrival.body.size()) == arrival.header.seq_nr);
  }
  void check() {
    for (sim::Node* node : {base_, robot_}) {
      fuzz::require(node->handshakes() <= link::Handshakes::kAcceptedMax + 2);
      node->links().for_each([&](const link::Link& link) {
        if (!link.is_up()) return;
        fuzz::require(link.keys().are_used());
        fuzz::require(link.certificate().system == other(*node).setup().system);
        fuzz::require(link.peer().system == other(*node).setup().system);
      });
    }
  }
  static bool is_linked(sim::Node& node) {
    return node.links().uplink() != nullptr && node.links().uplink()->is_up();
  }

  void deliver(std::size_t which, bool keep, fuzz::Input& in, std::size_t changes) {
    if (held_.empty()) return;
    const auto at = held_.begin() + static_cast<std::ptrdiff_t>(which % held_.size());
    Held one = *at;
    if (!keep) held_.erase(at);
    for (; changes > 0 && !one.bytes.empty(); --changes) {
      const std::size_t place = in.number<std::uint16_t>() % one.bytes.size();
      one.bytes[place] = static_cast<std::byte>(in.number<std::uint8_t>());
    }
    inject(one.from, one.to, one.bytes);
    run_for(0ms);
  }

  // --- the attacker knows tokens and cookies of whoever it hears
  void hear(const sim::NetAddress& to, std::span<const std::byte> bytes) {
    Bytes copy(bytes.begin(), bytes.end());
    const auto datagram = link::decode(copy);
    if (!datagram) return;
    if (const auto* retry = std::get_if<link::Retry>(&*datagram)) cookies_[to] = retry->cookie;
    if (const auto* hello = std::get_if<link::SealedHello>(&*datagram)) hello_ = hello->token;
  }
  template <typename Datagram>
  void give(const sim::NetAddress& from, const sim::Node& to, const Datagram& datagram) {
    std::array<std::byte, link::kDatagramBase> bytes{};
    inject(from, to.address(), std::span(bytes).first(link::encode(datagram, bytes)));
    run_for(0ms);
  }
  std::uint64_t token(sim::Node& of, std::uint8_t which) const {
    std::uint64_t ours = hello_;
    std::uint64_t theirs = hello_;
    of.links().for_each([&](const link::Link& link) {
      ours = link.our_token();
      theirs = link.their_token();
    });
    if (which % 4 == 0) return 1U + which / 4;
    if (which % 4 == 1) return hello_;
    return which % 4 == 2 ? ours : theirs;
  }
  void forge(sim::Node& to, fuzz::Input& in) {
    const auto kind = in.number<std::uint8_t>();
    const auto who = in.number<std::uint8_t>();
    const std::uint64_t token = this->token(to, in.number<std::uint8_t>());
    const sim::NetAddress from =
        who < 0x80 ? other(to).address() : sim::address_of(900U + who % 80U);
    switch (kind % 8) {
      case 0:
        return give(from, to, link::SealedHello{token});
      case 1:
        return give(from, to, link::Retry{token, in.number<std::uint8_t>()});
      case 2:
        return give(from, to, link::Refuse{.echo = token, .text = std::string_view("no")});
      case 3:
        return give(from, to, link::Reset{token});
      case 4:
        return give(from, to,
                    link::Welcome{.version = std::uint8_t(1U + kind / 8U % 2U),
                                  .resumed = kind >= 128,
                                  .echo = token,
                                  .token = token + who,
                                  .keep_alive = 300ms,
                                  .identity = other(to).links().self()});
      case 5:
        return give(from, to,
                    link::Hello{.token = token,
                                .cookie = cookies_[from],
                                .keep_alive = 300ms,
                                .identity = other(to).links().self()});
      default:
        return forge_crypto(from, to, token, in);
    }
  }
  void forge_crypto(const sim::NetAddress& from, const sim::Node& to, std::uint64_t token,
                    fuzz::Input& in) {
    const auto how = in.number<std::uint8_t>();
    const bool from_accepting = how % 2 == 1;
    const auto bytes = in.take(how / 2U % 64U);
    give(from, to,
         link::Crypto{.from_accepting = from_accepting,
                      .token = token,
                      .cookie = from_accepting ? 0 : cookies_[from],
                      .offset = how < 0x80 ? 0U : in.number<std::uint16_t>(),
                      .acknowledged = how < 0xC0 ? 0U : in.number<std::uint16_t>(),
                      .bytes = std::as_bytes(bytes)});
  }

  // --- the routers
  void restart(sim::Node& node, bool leaves_links) {
    if (leaves_links) {
      const Bytes state = node.hand_over(now());
      node.start(now(), state);
    } else {
      node.kill();
      node.start(now());
    }
    begin(node);
  }
  void renew(sim::Node& node, std::uint8_t number) {
    sim::ToyKeys keys = *node.setup().keys;
    keys.name.name = node.setup().name + std::to_string(number % 4);
    node.renew(now(), keys);
  }
  // The network is good meanwhile, and keys grow old.
  void pass_time(fuzz::Input& in) {
    const Duration time = 1min * (in.number<std::uint8_t>() % 64);
    if (passed_ + time > 70min) return;
    passed_ += time;
    free_ = true;
    run_for(time);
    free_ = false;
  }

  sim::Node* base_;
  sim::Node* robot_;
  std::array<core::ClientId, 2> clients_{};
  std::vector<Held> held_;
  std::map<sim::NetAddress, std::uint64_t> cookies_;  // by the address that got them
  std::uint64_t hello_ = 0;                           // the newest token of a HELLO
  Duration passed_{};
  bool free_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  Attacked fleet;
  for (int n = 0; n < 400 && !in.empty(); ++n) fleet.act(in);
  fleet.end();
  return 0;
}

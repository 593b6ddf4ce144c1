// Links with keys: what an attacker on the network, who hears and forges everything, cannot do.
#include <map>
#include <utility>

#include "router/link/datagram.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_sealed {

using Bytes = std::vector<std::byte>;

struct Sealed : Story {
  Sealed() : Story(1, {}, core::Compression::kOff, true) {}

  // From here on, keeps all datagrams between the base and the robot.
  void listen() {
    tap = [this](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
      if (&from == robot && to == base->address()) up.emplace_back(bytes.begin(), bytes.end());
      if (&from == base && to == robot->address()) down.emplace_back(bytes.begin(), bytes.end());
      return false;
    };
  }
  void replay(Node& to, const std::vector<Bytes>& all) {
    const NetAddress from = &to == base ? robot->address() : base->address();
    for (const Bytes& bytes : all) inject(from, to.address(), bytes);
  }
  const link::Link& link(Node& from, std::string_view to) {
    const link::Link* found = nullptr;
    from.links().for_each([&](const link::Link& one) {
      if (one.peer().name.view() == to) found = &one;
    });
    EXPECT_NE(found, nullptr) << to;
    return *found;
  }
  const link::LinkSessionCounters& counters(Node& from, std::string_view to) {
    return link(from, to).session().counters();
  }
  void send_to_gui(std::uint8_t number) {
    robot->send(now(), ladar, {.type = -7, .seq_nr = number, .dest = kGui, .src = kLadar});
  }
  [[nodiscard]] std::size_t events() const { return base->events.size() + robot->events.size(); }
  template <typename Datagram>
  void forge(const NetAddress& from, const NetAddress& to, const Datagram& datagram) {
    std::array<std::byte, link::kDatagramBase> bytes{};
    inject(from, to, std::span(bytes).first(link::encode(datagram, bytes)));
  }

  std::vector<Bytes> up;
  std::vector<Bytes> down;
};

bool is_data(const Bytes& bytes) { return bytes[0] == std::byte{1}; }

TEST(SealedLinks, CarryMessages) {
  Sealed s;
  s.begin();
  EXPECT_TRUE(s.gui_reaches_camera());
  EXPECT_TRUE(s.reaches(*s.host, s.camera, kCamera, *s.other, s.chassis, kChassis));
  EXPECT_EQ(s.link(*s.robot, "base").keys().suite(), "toy");
  EXPECT_EQ(s.base->handshakes(), 0U) << "they have ended";
}

// 280 bytes a second without keys.
TEST(SealedLinks, AnIdleLinkSendsKeepAlivesOnly) {
  Sealed s;
  s.begin();
  s.run_for(20s);
  std::map<int, std::size_t> kinds;
  std::size_t bytes = 0;
  s.tap = [&](Node& from, const NetAddress&, std::span<const std::byte> datagram) {
    if (&from != s.host) return false;
    ++kinds[std::to_integer<int>(datagram[0])];
    bytes += datagram.size() + 28;
    return false;
  };
  s.run_for(30s);
  EXPECT_EQ(kinds.size(), 1U);
  EXPECT_EQ(kinds[1], 100U);
  EXPECT_LE(bytes, 30 * 340U);
}

TEST(SealedLinks, ShowNothingThatIsSent) {
  Sealed s;
  s.listen();
  s.begin();
  const std::string secret = "the robot's secret plan";
  const auto body = std::as_bytes(std::span(secret));
  s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
  s.run_for(1s);
  ASSERT_EQ(s.base->arrivals(s.gui).size(), 1U);
  for (const Bytes& bytes : s.up) {
    EXPECT_TRUE(std::ranges::search(bytes, body).empty());
  }
}

// Each kind of datagram: at once, after new keys, after a restart of the other side.
TEST(SealedLinks, ReplaysChangeNothing) {
  Sealed s;
  s.listen();
  s.begin();
  for (std::uint8_t n = 0; n < 20; ++n) s.send_to_gui(n);
  s.run_for(1s);
  ASSERT_EQ(s.base->arrivals(s.gui).size(), 20U);
  const std::vector<Bytes> up = s.up;
  const std::vector<Bytes> down = s.down;
  std::size_t events = s.events();
  const auto replay_all = [&] {
    s.replay(*s.base, up);
    s.replay(*s.robot, down);
    s.run_for(5s);
    EXPECT_EQ(s.base->arrivals(s.gui).size(), 20U);
    EXPECT_TRUE(s.gui_reaches_camera());
  };
  replay_all();
  EXPECT_EQ(s.events(), events);
  EXPECT_GT(s.counters(*s.base, "robot").packets_replayed, 20U);
  s.run_for(1h + 1min);
  EXPECT_EQ(s.link(*s.base, "robot").keys().generation(), 1);
  const auto before =
      s.counters(*s.base, "robot").packets_old_key + s.counters(*s.base, "robot").packets_replayed;
  replay_all();
  EXPECT_EQ(s.events(), events);
  EXPECT_GE(
      s.counters(*s.base, "robot").packets_old_key + s.counters(*s.base, "robot").packets_replayed,
      before + 20);

  s.base->kill();
  s.base->start(s.now());
  s.gui = s.client(*s.base, kGui);
  ASSERT_TRUE(s.run_until([&] { return s.converged(); }, 3s));
  events = s.events();
  s.replay(*s.base, up);
  s.replay(*s.robot, down);
  s.run_for(5s);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), 0U);
  EXPECT_EQ(s.events(), events);
  EXPECT_TRUE(s.gui_reaches_camera());
}

// Datagrams returned to their sender, and those of other links, with the token of this one.
TEST(SealedLinks, DatagramsOfOtherDirectionsAndLinksAreForged) {
  Sealed s;
  s.begin();
  s.listen();
  for (std::uint8_t n = 0; n < 20; ++n) s.send_to_gui(n);
  s.run_for(1s);
  const std::size_t events = s.events();
  const std::size_t arrived = s.base->arrivals(s.gui).size();
  std::size_t given = 0;
  const auto with_token = [&](Bytes bytes, std::uint64_t token, std::uint32_t packet) {
    link::encode({.token = token, .packet = packet},
                 std::span(bytes).first<link::kDataHeaderSize>());
    ++given;
    return bytes;
  };
  const std::uint64_t to_robot = s.link(*s.robot, "base").our_token();
  const std::uint64_t to_base = s.link(*s.base, "other").our_token();
  const auto caught = s.up;
  std::uint32_t packet = 1'000'000;
  for (const Bytes& bytes : caught) {
    if (!is_data(bytes)) continue;
    s.inject(s.base->address(), s.robot->address(), with_token(bytes, to_robot, ++packet));
    s.inject(s.other->address(), s.base->address(), with_token(bytes, to_base, ++packet));
  }
  s.run_for(1s);
  EXPECT_EQ(
      s.counters(*s.robot, "base").packets_forged + s.counters(*s.base, "other").packets_forged,
      given);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), arrived);
  EXPECT_EQ(s.events(), events);
}

// Of one datagram that is held back: no alteration of it is accepted, none changes anything, and
// afterwards it is accepted itself.
TEST(SealedLinks, NoAlteredDatagramIsAccepted) {
  Sealed s;
  s.begin();
  s.run_for(1s);
  Bytes held;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (&from != s.robot || to != s.base->address()) return false;
    if (held.empty() && bytes.size() > 80) held.assign(bytes.begin(), bytes.end());
    return true;
  };
  const std::vector<std::byte> body(100);
  s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
  s.run_for(1ms);
  ASSERT_FALSE(held.empty());
  const auto give = [&](const Bytes& bytes) {
    s.inject(s.robot->address(), s.base->address(), bytes);
    s.run_for(0ms);
    EXPECT_EQ(s.base->arrivals(s.gui).size(), 0U);
  };
  for (std::size_t bit = 0; bit < 8 * held.size(); ++bit) {
    // The third byte of the header is not used, and is authenticated like the others.
    Bytes altered = held;
    altered[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    give(altered);
  }
  for (std::size_t size = 0; size < held.size(); ++size)
    give(Bytes(held.begin(), held.begin() + static_cast<std::ptrdiff_t>(size)));
  Bytes longer = held;
  longer.push_back(std::byte{0});
  give(longer);
  s.inject(s.robot->address(), s.base->address(), held);
  s.run_for(0ms);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), 1U);
  EXPECT_EQ(Story::find_event(*s.base, core::EventKind::kLinkDown), nullptr);
}

// Whoever hears a link knows its tokens.
TEST(SealedLinks, NothingForgedEndsASession) {
  Sealed s;
  s.begin();
  s.run_for(1s);
  const std::size_t events = s.events();
  const std::size_t events_of_robot = s.robot->events.size();
  const link::Link& link = s.link(*s.robot, "base");
  const NetAddress& base = s.base->address();
  const NetAddress& robot = s.robot->address();
  for (int i = 0; i < 50; ++i) {
    s.forge(base, robot, link::Reset{link.their_token()});
    s.forge(robot, base, link::Reset{link.our_token()});
    s.forge(base, robot, link::Retry{link.our_token(), 4711});
    s.forge(base, robot, link::Refuse{.echo = link.our_token(), .text = std::string_view("no")});
    link::Welcome welcome{.echo = link.our_token(), .token = 4711, .identity = link.peer()};
    s.forge(base, robot, welcome);
    link::Hello hello{.token = link.our_token(),
                      .resume = link.their_token(),
                      .identity = s.robot->links().self()};
    s.forge(robot, base, hello);
    s.forge(robot, base, link::SealedHello{link.our_token()});
    Bytes close(64);
    link::encode({.token = link.their_token(), .packet = 999'999},
                 std::span(close).first<link::kDataHeaderSize>());
    close[16] = std::byte{9};
    s.inject(robot, base, close);
    s.run_for(100ms);
  }
  for (const core::Event& event : s.base->events) EXPECT_NE(event.kind, core::EventKind::kLinkDown);
  EXPECT_EQ(s.robot->events.size(), events_of_robot);
  EXPECT_LE(s.events(), events + 1) << "the plain HELLO is refused, and that is logged";
  EXPECT_TRUE(s.gui_reaches_camera());
}

// Whoever hears a HELLO can forge answers to it, sooner and more often than the base gives one.
TEST(SealedLinks, AListenerDoesNotKeepOutARobotThatIsFarAway) {
  Sealed s;
  s.set_faults({.delay = 100ms});
  std::uint64_t token = 0;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (&from != s.robot || to != s.base->address() || bytes[0] != std::byte{2}) return false;
    Bytes copy(bytes.begin(), bytes.end());
    const auto datagram = link::decode(copy);
    if (const auto* hello = std::get_if<link::SealedHello>(&*datagram)) token = hello->token;
    return false;
  };
  s.base->start(s.now());
  s.robot->start(s.now());
  std::uint64_t forged = 0;
  const auto is_up = [&] { return Story::links_up(*s.base) == 1; };
  while (!s.run_until(is_up, 90ms) && forged < 300)
    s.forge(s.base->address(), s.robot->address(), link::Retry{token, ++forged});
  EXPECT_TRUE(is_up());
  EXPECT_GT(forged, 0U);
}

// Clocks of boards without a battery, and of receivers that find out what time it is.
TEST(SealedLinks, StayWhateverTheClocksSay) {
  constexpr Duration kSince1970 = 1'700'000'000s;
  constexpr Duration kUntil2106 = (std::int64_t{1} << 32) * 1s - kSince1970;
  Sealed s;
  s.robot->jump_wall(-kSince1970);
  s.other->jump_wall(kUntil2106 + 1s);
  s.begin();
  const std::size_t events = s.events();
  for (const Duration step : {kSince1970 + kUntil2106, -kUntil2106, Duration(-1s), Duration(48h)}) {
    for (int n = 0; n < 30; ++n) {
      s.robot->jump_wall(n % 2 == 0 ? step : -step);
      s.base->jump_wall(n % 3 == 0 ? -step : step / 2);
      s.run_for(100ms);
    }
    EXPECT_TRUE(s.gui_reaches_camera());
    EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.other, s.chassis, kChassis));
  }
  s.run_for(1h + 1min);
  EXPECT_EQ(s.link(*s.base, "robot").keys().generation(), 1) << "their age is no time of day";
  EXPECT_TRUE(s.gui_reaches_camera());
  EXPECT_EQ(s.events(), events);
}

// New keys every hour, without a gap.
TEST(SealedLinks, KeysAreRenewedWithoutALoss) {
  Sealed s;
  s.begin();
  const std::size_t events = s.events();
  std::size_t sent = 0;
  for (int i = 0; i < 3 * 3600; ++i) {
    s.send_to_gui(static_cast<std::uint8_t>(++sent));
    s.run_for(1s);
  }
  EXPECT_EQ(s.base->arrivals(s.gui).size(), sent);
  EXPECT_GE(s.link(*s.base, "robot").keys().generation(), 3);
  EXPECT_EQ(s.link(*s.base, "robot").keys().generation(),
            s.link(*s.robot, "base").keys().generation());
  EXPECT_EQ(s.events(), events);
  EXPECT_EQ(s.counters(*s.base, "robot").packets_forged, 0U);
  EXPECT_EQ(s.counters(*s.base, "robot").packets_lost, 0U);
}

TEST(SealedLinks, ANewAddressEachSecond) {
  Sealed s;
  s.begin();
  for (std::size_t i = 0; i < 10; ++i) {
    s.move(*s.robot, address_of(200 + i), 100ms);
    s.run_for(1s);
    EXPECT_TRUE(s.gui_reaches_camera());
  }
  EXPECT_EQ(Story::find_event(*s.base, core::EventKind::kLinkDown), nullptr);
}

// --- who may connect

std::string refusal_at(Node& node) {
  const core::Event* event = Story::find_event(node, core::EventKind::kLinkRefused);
  return event == nullptr ? "" : std::string(event->text.view());
}

struct Pair : SimulatedNetwork {
  Pair(std::optional<ToyKeys> base_keys, std::optional<ToyKeys> robot_keys) : SimulatedNetwork(7) {
    base = &add({.name = "base",
                 .role = core::Role::kTop,
                 .links = {sub_link()},
                 .keys = std::move(base_keys)});
    robot = &add({.name = "robot",
                  .system = 3,
                  .links = {super_link(address_of(0))},
                  .keys = std::move(robot_keys)});
    set_faults({.delay = 1ms});
    base->start(now());
    robot->start(now());
    run_for(2s);
  }
  [[nodiscard]] bool is_up() const { return Story::links_up(*robot) + Story::links_up(*base) == 2; }
  Node* base;
  Node* robot;
};

ToyKeys keys(std::uint64_t fleet, core::Role role, std::uint16_t system) {
  return {.fleet = fleet, .name = {.role = role, .system = system, .id = 1}};
}
const ToyKeys kBaseKeys = keys(1, core::Role::kTop, 0);

TEST(SealedAdmission, TakesRoutersOfTheFleet) {
  EXPECT_TRUE(Pair(kBaseKeys, keys(1, core::Role::kSystem, 3)).is_up());
}

TEST(SealedAdmission, RefusesOthersAndBothSidesSayWhy) {
  const auto why = [](std::optional<ToyKeys> base, std::optional<ToyKeys> robot) {
    Pair pair(std::move(base), std::move(robot));
    EXPECT_EQ(Story::links_up(*pair.base) + Story::links_up(*pair.robot), 0U);
    EXPECT_NE(refusal_at(*pair.base), "");
    EXPECT_EQ(refusal_at(*pair.base), refusal_at(*pair.robot));
    return refusal_at(*pair.robot);
  };
  using testing::Test;
  const auto has = [](const std::string& text, std::string_view part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(why(kBaseKeys, {}), "links only with routers that have keys"));
  EXPECT_TRUE(has(why({}, keys(1, core::Role::kSystem, 3)), "this router has no keys"));
  EXPECT_TRUE(has(why(kBaseKeys, keys(1, core::Role::kSystem, 4)),
                  "is system 3/1, its certificate is for system 4/1"));
}

TEST(SealedAdmission, RefusesOtherFleetsAndImpostorsOfTheBase) {
  EXPECT_FALSE(Pair(kBaseKeys, keys(2, core::Role::kSystem, 3)).is_up());
  // A robot of the fleet pretends to be the base.
  Pair pair(keys(1, core::Role::kSystem, 9), keys(1, core::Role::kSystem, 3));
  EXPECT_EQ(Story::links_up(*pair.robot), 0U);
  EXPECT_NE(refusal_at(*pair.robot).find("its certificate is for system 9/1"), std::string::npos);
}

// Where robots without keys are admitted as well: a silent link with keys is none of theirs.
TEST(SealedAdmission, WhoHasNoKeysDoesNotTakeTheLinkOfASilentRobot) {
  Pair pair(kBaseKeys, keys(1, core::Role::kSystem, 3));
  ASSERT_TRUE(pair.is_up());
  std::vector<link::LinkSettings> settings{pair.base->setup().links.front(), sub_link(3)};
  pair.base->links().configure(pair.now(), settings);
  const link::Link* link = pair.base->links().link(0);
  const std::uint64_t token = link->their_token();
  pair.cut("base", "robot");
  pair.run_for(3s);
  ASSERT_EQ(link->state(), link::Link::State::kSilent);
  link::Hello hello{
      .kind = core::LinkKind::kSuper, .keep_alive = 300ms, .identity = pair.robot->links().self()};
  std::size_t refused = 0;
  const auto send = [&] {
    std::array<std::byte, link::kDatagramBase> bytes{};
    pair.inject(address_of(900), pair.base->address(),
                std::span(bytes).first(link::encode(hello, bytes)));
    pair.run_for(1ms);
  };
  pair.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (&from != pair.base || to != address_of(900)) return false;
    Bytes copy(bytes.begin(), bytes.end());
    const auto datagram = link::decode(copy);
    if (const auto* retry = std::get_if<link::Retry>(&*datagram)) hello.cookie = retry->cookie;
    refused += std::holds_alternative<link::Refuse>(*datagram) ? 1U : 0U;
    EXPECT_FALSE(std::holds_alternative<link::Welcome>(*datagram));
    return true;
  };
  for (const std::uint64_t other : {token, std::uint64_t{4711}}) {
    hello.token = other;
    hello.cookie = 0;
    send();
    send();
  }
  EXPECT_EQ(refused, 2U);
  EXPECT_TRUE(link->keys().are_used());
  EXPECT_EQ(link->their_token(), token);
  pair.cut("base", "robot", false);
  EXPECT_TRUE(pair.run_until([&] { return pair.is_up(); }, 2s));
  EXPECT_EQ(link->their_token(), token) << "its session goes on";
}

// --- strangers

TEST(SealedAdmission, StrangersWithoutACookieGetNothing) {
  Sealed s;
  s.begin();
  const std::size_t events = s.base->events.size();
  std::size_t in = 0;
  std::size_t out = 0;
  s.tap = [&](Node&, const NetAddress& to, std::span<const std::byte> bytes) {
    if (to < address_of(900)) return false;
    out += bytes.size();
    return true;
  };
  for (std::uint64_t n = 1; n <= 2000; ++n) {
    s.forge(address_of(900 + n), s.base->address(), link::SealedHello{n});
    in += link::kHelloSize;
  }
  s.run_for(1s);
  EXPECT_LE(out, in / 10);
  EXPECT_EQ(s.base->handshakes(), 0U);
  out = 0;
  for (std::uint64_t n = 1; n <= 2000; ++n)
    s.forge(address_of(900 + n), s.base->address(), link::Crypto{.token = n, .cookie = n});
  s.run_for(1s);
  EXPECT_EQ(out, 0U);
  EXPECT_EQ(s.base->handshakes(), 0U);
  EXPECT_EQ(s.base->events.size(), events);
}

// With cookies of their own addresses: they hold up to 64 handshakes for ten seconds, and routers
// of the fleet link all the same.
TEST(SealedAdmission, HalfHandshakesAreBoundedAndEnd) {
  Sealed s;
  s.begin();
  std::map<NetAddress, std::uint64_t> cookies;
  s.tap = [&](Node&, const NetAddress& to, std::span<const std::byte> bytes) {
    if (to < address_of(900)) return false;
    Bytes copy(bytes.begin(), bytes.end());
    const auto datagram = link::decode(copy);
    if (const auto* retry = std::get_if<link::Retry>(&*datagram)) cookies[to] = retry->cookie;
    return true;
  };
  for (std::uint64_t n = 1; n <= 200; ++n)
    s.forge(address_of(900 + n), s.base->address(), link::SealedHello{n});
  s.run_for(10ms);
  ASSERT_EQ(cookies.size(), 200U);
  Bytes first(163);
  first[0] = std::byte{160};
  first[2] = std::byte{1};
  std::uint64_t n = 0;
  for (const auto& [address, cookie] : cookies) {
    ++n;
    std::uint64_t token = 0;
    for (std::uint64_t t = 1; t <= 200; ++t)
      if (address_of(900 + t) == address) token = t;
    const link::Crypto crypto{.token = token, .cookie = cookie, .bytes = first};
    s.forge(address_of(899), s.base->address(), crypto);
    s.run_for(0ms);
    EXPECT_EQ(s.base->handshakes(), std::min<std::uint64_t>(n - 1, 64)) << "a stolen cookie";
    s.forge(address, s.base->address(), crypto);
    s.run_for(0ms);
  }
  EXPECT_EQ(s.base->handshakes(), 64U);
  s.other->kill();
  s.other->start(s.now());
  s.chassis = s.client(*s.other, kChassis);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 5s));
  s.run_for(11s);
  EXPECT_EQ(s.base->handshakes(), 0U);
}

// A hundred robots call at once. A handshake takes the base 30 ms, in three steps; the robots
// have their own computers. No handshake is done twice, so the base needs little more than its own
// time.
TEST(SealedLinks, AFleetRejoinsARestartedBaseInTheTimeOfItsHandshakes) {
  constexpr std::uint16_t kRobots = 100;
  constexpr Duration kOne = 3 * 10ms;
  SimulatedNetwork network(1);
  network.seal_all();
  network.set_faults({.delay = 5ms});
  Node& base = network.add({.name = "base",
                            .role = core::Role::kTop,
                            .links = {sub_link()},
                            .block_bytes = 1U << 20,
                            .handshake_step = kOne / 3});
  for (std::uint16_t n = 1; n <= kRobots; ++n)
    network.add({.name = "robot" + std::to_string(n),
                 .system = n,
                 .links = {super_link(address_of(0))},
                 .block_bytes = 1U << 20});
  for (const auto& node : network.nodes()) node->start(network.now());
  const auto all_up = [&] { return Story::links_up(base) == kRobots; };
  const auto report = [&] {
    const auto counters = base.links().counters().handshakes;
    return std::to_string(counters.accepted) + " accepted, " + std::to_string(counters.answered) +
           " answered, " + std::to_string(counters.given_up) + " given up, " +
           std::to_string(counters.turned_away) + " turned away";
  };
  const Duration allowed = kRobots * kOne * 3 / 2;
  EXPECT_TRUE(network.run_until(all_up, allowed)) << report();
  network.run_for(1s);
  base.kill();
  network.run_for(50ms);
  base.start(network.now());
  const Time restarted = network.now();
  EXPECT_TRUE(network.run_until(all_up, allowed)) << report();
  EXPECT_GE(network.now() - restarted, kRobots * kOne) << "the base has one thread for handshakes";
  const auto counters = base.links().counters().handshakes;
  EXPECT_EQ(counters.answered, kRobots) << report();
  EXPECT_EQ(counters.given_up, 0U) << report();
}

// Whoever ends each session, because it does not understand the other router, does not make the
// other one shake hands without end.
TEST(SealedLinks, SessionsThatEndAtOnceBeginSeldom) {
  Sealed s;
  s.begin();
  const auto before = s.base->links().counters().handshakes.accepted;
  for (int n = 0; n < 1000; ++n) {
    s.run_for(10ms);
    s.base->links().for_each([&](const link::Link& one) {
      if (one.peer().name.view() == "robot" && one.is_up()) {
        s.base->links().act(s.now(), "robot", link::Links::Action::kReset);
        s.base->end_turn(s.now());
      }
    });
  }
  EXPECT_GE(s.base->links().counters().handshakes.accepted - before, 3U);
  EXPECT_LE(s.base->links().counters().handshakes.accepted - before, 5U);
}

}  // namespace stories_sealed
}  // namespace tims::sim

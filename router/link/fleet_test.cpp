#include "router/link/fleet.h"

#include <array>
#include <memory>

#include <gtest/gtest.h>

#include "router/link/links.h"

namespace tims::link {
namespace fleet_test {

using namespace std::chrono_literals;

Identity identity(Role role, std::uint8_t system, std::uint8_t id, std::uint64_t epoch) {
  return {.epoch = epoch, .role = role, .system = system, .id = id, .message_max = 1U << 20};
}

NetAddress udp(std::uint8_t host) { return NetAddress::v4(10, 0, 0, host, 2010); }

// Announced as the participant and from the host that have the number of its epoch.
Announcement announced(const Identity& identity) {
  const auto number = static_cast<std::uint8_t>(identity.epoch);
  return {.fleet = std::string_view("harbour"),
          .identity = identity,
          .dds = NetAddress::dds({number}),
          .udp = {udp(number)}};
}

const std::vector kBoth{PathKind::kUdp, PathKind::kDds};
const Identity kBase = identity(Role::kTop, 0, 1, 10);
const Identity kOne = identity(Role::kSystem, 1, 1, 11);
const Identity kOther = identity(Role::kSystem, 1, 3, 13);
const Identity kTwo = identity(Role::kSystem, 2, 1, 12);
const Identity kHost = identity(Role::kSubsystem, 1, 2, 21);

struct NoSink final : core::Port, core::RouterHooks {
  core::Outcome deliver(Time, const core::Receiver&, const core::Message&) override {
    return core::Outcome::kDelivered;
  }
  void reply(Time, const core::Receiver&, const Header&) override {}
  void close(const core::Receiver&, core::CloseReason) override {}
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override {}
};

// A router with one link, and its fleet.
class FleetTest : public testing::Test {
 protected:
  void be(const Identity& self, const LinkSettings& settings) {
    fleet = std::make_unique<Fleet>(self);
    router = std::make_unique<core::Router>(
        core::RouterSettings{.address = self.address(), .role = self.role, .clients_max = 8},
        core::HashSeed{1, 2}, sink);
    link = std::make_unique<Link>(*router, pool, memory, done, around, 0, settings, now);
    around.identity = self;
  }
  void be(const Identity& self) { be(self, {.to = std::string(kAutomatic), .paths = kBoth}); }
  void announce(std::initializer_list<Identity> all) {
    for (const Identity& one : all) EXPECT_TRUE(fleet->add(announced(one)));
  }
  std::vector<std::uint64_t> candidates(bool alone = true) {
    std::vector<std::uint64_t> epochs;
    for (const Announcement* a : fleet->candidates(*link, alone))
      epochs.push_back(a->identity.epoch);
    return epochs;
  }
  void come_up(const Identity& peer) {
    const NetAddress at = udp(static_cast<std::uint8_t>(peer.epoch));
    link->set_targets(now, PathKind::kUdp, {&at, 1});
    link->on_welcome(now, at, {.token = 7, .keep_alive = 300ms, .identity = peer}, {});
    ASSERT_TRUE(link->is_up());
  }
  using Epochs = std::vector<std::uint64_t>;

  struct Around final : LinkContext {
    std::uint64_t random() override { return ++number; }
    [[nodiscard]] const Identity& self() const override { return identity; }
    [[nodiscard]] bool has_keys() const override { return false; }
    [[nodiscard]] std::int64_t wall_ns() const override { return 0; }
    void send(const NetAddress&, std::span<const std::byte>) override {}
    void lost(core::ClientId, const Header&, core::Outcome) override {}
    void shake_hands(Time, const NetAddress&, const Retry&, std::span<const std::byte>,
                     bool) override {}
    void changed() override {}
    Packing& packing() override { return compression; }
    bool take_packed(core::ClientId, core::Message&, PackingCounters&) override { return false; }
    bool has_room_to_unpack() override { return true; }
    void begin_lists(Time, const Link&) override {}
    bool on_list_message(Time, std::uint32_t, const core::Message&) override { return false; }
    void end_lists(Time, std::uint32_t) override {}
    Packing compression{{}, {}};
    std::uint64_t number = 0;
    Identity identity{};
  };
  Time now{100s};
  alignas(core::BlockPool::kBlockSize) std::array<std::byte, 1U << 18> blocks{};
  std::array<std::byte, 1U << 16> messages{};
  core::BlockPool pool{blocks};
  MessageMemory memory{messages, 1U << 12, 1U << 16};
  std::vector<MessageBuffer> done;
  NoSink sink;
  Around around;
  std::unique_ptr<core::Router> router;
  std::unique_ptr<Fleet> fleet;
  std::unique_ptr<Link> link;
};

TEST_F(FleetTest, OnlyNewsIsNews) {
  be(kOne);
  EXPECT_TRUE(fleet->add(announced(kBase)));
  EXPECT_FALSE(fleet->add(announced(kBase)));
  EXPECT_FALSE(fleet->add(announced(kOne))) << "that is us";
  EXPECT_FALSE(fleet->add({.identity = kTwo})) << "from nowhere";
  Announcement moved = announced(kBase);
  moved.udp = {udp(99)};
  EXPECT_TRUE(fleet->add(moved));
  EXPECT_EQ(fleet->routers().size(), 1U);
  fleet->remove(moved.dds);
  EXPECT_TRUE(fleet->routers().empty());
  EXPECT_TRUE(candidates().empty());
}

TEST_F(FleetTest, IsBounded) {
  be(kOne);
  const auto one_of = [](std::size_t n) {
    return Announcement{
        .fleet = std::string_view("harbour"),
        .identity = identity(Role::kSystem, 1, 1, 100 + n),
        .dds = NetAddress::dds({static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)})};
  };
  for (std::size_t n = 1; n < Fleet::kRoutersMax; ++n) ASSERT_TRUE(fleet->add(one_of(n)));
  EXPECT_TRUE(fleet->add(one_of(Fleet::kRoutersMax))) << "the last one";
  EXPECT_FALSE(fleet->add(one_of(Fleet::kRoutersMax + 1)));
  EXPECT_EQ(fleet->routers().size(), Fleet::kRoutersMax);
  Announcement news = one_of(7);
  news.udp = {udp(99)};
  EXPECT_TRUE(fleet->add(news)) << "of a known one";
  fleet->remove(news.dds);
  EXPECT_TRUE(fleet->add(one_of(Fleet::kRoutersMax + 1)));
  Announcement by_udp = one_of(8);
  by_udp.dds.kind = PathKind::kUdp;
  EXPECT_FALSE(fleet->add(by_udp));
}

TEST_F(FleetTest, ASystemRouterLooksForATopLevelOne) {
  be(kOne);
  announce({kHost, kTwo, kOther, kBase});
  EXPECT_EQ(candidates(), Epochs{10});
  EXPECT_EQ(fleet->looked_for(), "a top-level router");
}

TEST_F(FleetTest, ASubsystemLooksForTheSystemRouterOfItsSystem) {
  be(kHost);
  announce({kBase, kTwo});
  EXPECT_TRUE(candidates().empty());
  announce({kOther, kOne});
  EXPECT_EQ(candidates(), (Epochs{11, 13})) << "the lowest id first, at all of them";
  EXPECT_EQ(fleet->looked_for(), "a system router of system 1");
}

TEST_F(FleetTest, ATopLevelRouterLooksForNobody) {
  be(kBase);
  announce({kOne, identity(Role::kTop, 0, 2, 14)});
  EXPECT_TRUE(candidates().empty());
}

TEST_F(FleetTest, TheLinkedRouterIsTheOnlyCandidateWhileTheLinkIsUp) {
  be(kHost);
  announce({kOne, kOther});
  come_up(kOther);
  EXPECT_EQ(candidates(), Epochs{13});
  link->take_down(now, Link::State::kSilent);
  EXPECT_EQ(candidates(), (Epochs{13, 11})) << "then the first of several";
}

TEST_F(FleetTest, AnAddressMeansTheRouterThatAnnouncesIt) {
  be(kHost, {.to = udp(13).to_string(), .paths = kBoth});
  announce({kOne, kOther});
  const NetAddress target = udp(13);
  link->set_targets(now, PathKind::kUdp, {&target, 1});
  EXPECT_EQ(candidates(), Epochs{13});
  be(kOne, {.kind = LinkKind::kPeer, .to = udp(12).to_string(), .paths = kBoth});
  announce({kBase, kTwo});
  const NetAddress peer = udp(12);
  link->set_targets(now, PathKind::kUdp, {&peer, 1});
  EXPECT_EQ(candidates(), Epochs{12}) << "a peer has its address only";
}

TEST_F(FleetTest, WithoutUdpAnAddressMeansNothingAndTheRoleAllToAnOnlyLink) {
  be(kOne, {.to = udp(10).to_string(), .paths = {PathKind::kDds}});
  announce({kBase});
  EXPECT_EQ(candidates(), Epochs{10});
  EXPECT_TRUE(candidates(false).empty()) << "another link may mean it";
}

TEST_F(FleetTest, AnAcceptingLinkLooksOnlyForTheRouterItAccepted) {
  be(kOne, {.kind = LinkKind::kSub, .connects = false, .paths = kBoth});
  announce({kBase, kHost});
  EXPECT_TRUE(candidates().empty());
  EXPECT_TRUE(
      link->accept(now, udp(21), {.token = 5, .keep_alive = 300ms, .identity = kHost}, 6, {}));
  EXPECT_EQ(candidates(), Epochs{21});
}

TEST_F(FleetTest, ALinkWithKeysAcceptsNobodyWithoutThem) {
  be(kOne, {.kind = LinkKind::kSub, .connects = false, .secure = true});
  EXPECT_FALSE(
      link->accept(now, udp(21), {.token = 5, .keep_alive = 300ms, .identity = kHost}, 6, {}));
  EXPECT_FALSE(link->is_up());
  EXPECT_EQ(link->their_token(), 0U);
}

TEST_F(FleetTest, ADoubleHasOurSystemAndId) {
  be(kOne);
  EXPECT_FALSE(fleet->is_double(kOne));
  EXPECT_FALSE(fleet->is_double(kOther));
  EXPECT_FALSE(fleet->is_double(kTwo));
  EXPECT_TRUE(fleet->is_double(identity(Role::kSystem, 1, 1, 99)));
  EXPECT_TRUE(fleet->is_double(identity(Role::kSubsystem, 1, 1, 99)));
}

// After the process of DDS has died there, the router has another participant at once.
TEST_F(FleetTest, ARouterThatIsAnnouncedTwiceIsReachedAtBoth) {
  be(kOne);
  announce({kBase, kOther});
  come_up(kBase);
  Announcement again = announced(kBase);
  again.dds = NetAddress::dds({99});
  EXPECT_TRUE(fleet->add(again));
  EXPECT_EQ(candidates(), (Epochs{10, 10}));
  fleet->remove(announced(kBase).dds);
  EXPECT_EQ(candidates(), Epochs{10});
}

}  // namespace fleet_test
}  // namespace tims::link

// A robot that was broken into has its keys and its link, and sends what it likes over it.
#include "tests/sim/story.h"
#include "wire/header.h"

namespace tims::sim {
namespace stories_stolen {

struct Stolen : Story {
  Stolen() : Story(1, {}, core::Compression::kOff, true) { begin(); }

  // Past the checks of the robot's own router.
  void send_over_link(const Header& header, std::uint8_t hops = 0,
                      const std::vector<std::byte>& body = std::vector<std::byte>(4)) {
    std::vector<std::byte> bytes(kHeaderSize);
    bytes.insert(bytes.end(), body.begin(), body.end());
    Header whole = header;
    whole.length = static_cast<std::uint32_t>(bytes.size());
    wire::encode_header(whole, std::span(bytes).first<kHeaderSize>());
    robot->links().for_each([&](const link::Link& one) {
      if (one.peer().name.view() != "base") return;
      (void)robot->links().deliver(now(), {.token = one.slot()},
                                   {.header = whole, .bytes = bytes, .hops = hops});
    });
    robot->end_turn(now());
    run_for(100ms);
  }
  [[nodiscard]] std::uint64_t at_base(core::Outcome outcome) {
    return base->router().messages().total(outcome).messages;
  }
};

// Commands for routers, as programs send them to their own: to register, to remove, to connect.
TEST(StolenRobot, CommandsForTheRouterAboveAreNotCarriedOut) {
  Stolen s;
  std::uint64_t sent = 0;
  for (int type = -128; type < 128; ++type) {
    for (const Address src : {Address(), kChassis, kGui, kLadar}) {
      s.send_over_link({.type = static_cast<std::int8_t>(type), .dest = Address(), .src = src});
      ++sent;
    }
  }
  EXPECT_GT(sent, 0U);
  EXPECT_TRUE(s.converged());
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.other, s.chassis, kChassis));
  EXPECT_TRUE(s.gui_reaches_camera());
  EXPECT_EQ(Story::links_up(*s.base), 2U);
}

TEST(StolenRobot, SourcesOfOthersAreCountedAndNotPassedOn) {
  Stolen s;
  const std::size_t before = s.other->arrivals(s.chassis).size();
  for (const std::uint8_t flags : {std::uint8_t{0}, flag::kTrace, flag::kStream})
    for (const Address src : {kGui, kChassis, Address(), Address(0x00000001), kLadar})
      s.send_over_link({.flags = flags, .type = type::kData, .dest = kChassis, .src = src});
  EXPECT_EQ(s.at_base(core::Outcome::kForgedSource), 12U);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), before + 3) << "its own";
}

// The mailbox that data are sent to, or not any more, is named in the body.
TEST(StolenRobot, DataAreAskedForItsOwnMailboxesOnly) {
  Stolen s;
  std::size_t expected = s.other->arrivals(s.chassis).size();
  for (const std::int8_t type : {type::kGetContData, type::kStopContData}) {
    for (const Address mailbox : {kGui, kChassis, kLadar}) {
      std::vector<std::byte> body(type == type::kGetContData ? 4 : 0);
      for (int shift = 24; shift >= 0; shift -= 8)
        body.push_back(static_cast<std::byte>(mailbox.raw() >> shift & 0xFF));
      s.send_over_link({.flags = 0, .type = type, .dest = kChassis, .src = kLadar}, 0, body);
    }
    ++expected;
  }
  EXPECT_EQ(s.at_base(core::Outcome::kForgedSource), 4U);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), expected) << "its own";
}

TEST(StolenRobot, MessagesThatClaimToHaveComeFarEnd) {
  Stolen s;
  const std::size_t before = s.other->arrivals(s.chassis).size();
  for (const std::uint8_t hops : {std::uint8_t{254}, std::uint8_t{core::kHopsMax - 1}})
    s.send_over_link({.type = 3, .dest = kChassis, .src = kLadar}, hops);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), before);
  EXPECT_EQ(s.at_base(core::Outcome::kHopLimit), 2U);
  s.send_over_link({.type = 3, .dest = kChassis, .src = kLadar}, core::kHopsMax - 2);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), before + 1);
  EXPECT_EQ(Story::links_up(*s.base), 2U);
}

}  // namespace stories_stolen
}  // namespace tims::sim

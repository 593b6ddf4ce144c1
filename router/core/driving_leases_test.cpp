#include "router/core/driving_leases.h"

#include <bit>

#include <gtest/gtest.h>

#include "router/core/router_fixture.h"

namespace tims::core::test {
namespace driving_leases_test {

using namespace std::chrono_literals;

constexpr Address kConsole{0x00020301};  // Gui
constexpr Address kTool{0x000F0000};
constexpr Address kChassis{0x03110000};
constexpr Address kPilot{0x03180000};
constexpr Address kPath{0x03250000};
constexpr Address kStick{0x03170000};
constexpr Address kOtherStick{0x03170100};

// Of the classes' messages.
constexpr std::int8_t kMove = 21;
constexpr std::int8_t kSetActivePilot = 23;
constexpr std::int8_t kSetDestination = 21;
constexpr std::int8_t kHold = 22;

class DrivingLeasesTest : public RouterTest {
 protected:
  DrivingLeasesTest() {
    robot_ = connect(PortKind::kLocal, "robot");
    for (const Address address : {kChassis, kPilot, kPath})
      router_.register_mailbox(now_, robot_, address);
    console_ = connect(PortKind::kWebSocket);
    router_.register_mailbox(now_, console_, kConsole);
    router_.register_mailbox(now_, console_, kStick);
    tool_ = connect(PortKind::kTcp);
    router_.register_mailbox(now_, tool_, kTool);
  }

  LeaseResult change(ClientId from, LeaseVerb verb, std::string_view name = "tablet 2",
                     Address mailbox = {}) {
    return router_.change_lease(now_, from, verb,
                                {.robot = 3, .holder = name, .mailbox = mailbox, .stick = kStick});
  }
  Outcome command(ClientId from, Address source, Address dest, std::int8_t type,
                  const Bytes& body = Bytes(12, std::byte{1})) {
    return send(from, {.type = type, .dest = dest, .src = source}, body);
  }
  Outcome tool_moves() { return command(tool_, kTool, kChassis, kMove); }
  void pass(Duration time) {
    now_ += time;
    if (now_ >= router_.next_timeout()) router_.on_timeout(now_);
  }

  ClientId robot_{};
  ClientId console_{};
  ClientId tool_{};
};

TEST_F(DrivingLeasesTest, WithoutALeaseEverybodyDrives) {
  EXPECT_EQ(tool_moves(), Outcome::kDelivered);
  EXPECT_EQ(command(console_, kConsole, kPilot, kSetDestination), Outcome::kDelivered);
}

TEST_F(DrivingLeasesTest, OthersAreRefusedWithAnOutcomeOfTheirOwn) {
  ASSERT_EQ(change(console_, LeaseVerb::kTake), LeaseResult::kDone);
  EXPECT_EQ(tool_moves(), Outcome::kNoLease);
  EXPECT_EQ(count(PortKind::kTcp, Outcome::kNoLease), 1U);
  ASSERT_EQ(sink_.replies.size(), 1U);
  EXPECT_EQ(sink_.replies[0].header.type, type::kError);
  EXPECT_EQ(sink_.replies[0].header.dest, kTool);
  EXPECT_EQ(sink_.events.back().kind, EventKind::kDrivingRefused);
  EXPECT_EQ(sink_.events.back().text.view(), "tablet 2 on robot 3");
  EXPECT_EQ(command(tool_, kTool, kPilot, kSetDestination), Outcome::kNoLease);
  EXPECT_EQ(command(tool_, kTool, kPath, 23), Outcome::kNoLease);
  EXPECT_EQ(command(tool_, kTool, kChassis, kSetActivePilot), Outcome::kNoLease);
  EXPECT_EQ(count(EventKind::kDrivingRefused), 1U) << "one event a second";
  // Another robot.
  const ClientId other = connect(PortKind::kLocal);
  router_.register_mailbox(now_, other, Address(0x04110000));
  EXPECT_EQ(command(tool_, kTool, Address(0x04110000), kMove), Outcome::kDelivered);
}

TEST_F(DrivingLeasesTest, TheHolderAndTheRobotItselfDrive) {
  change(console_, LeaseVerb::kTake);
  EXPECT_EQ(command(console_, kConsole, kPilot, kSetDestination), Outcome::kDelivered);
  EXPECT_EQ(command(console_, kStick, kPilot, type::kData), Outcome::kDelivered);
  EXPECT_EQ(command(robot_, kPilot, kChassis, kMove), Outcome::kDelivered);
  const ClientId arm = link(LinkKind::kSub, 3, "arm");
  EXPECT_EQ(command(arm, Address(0x03180100), kChassis, kMove), Outcome::kDelivered)
      << "a pilot on another host";
  const ClientId robot4 = link(LinkKind::kPeer, 4, "robot4");
  EXPECT_EQ(command(robot4, Address(0x04180100), kChassis, kMove), Outcome::kNoLease)
      << "a pilot of another robot";
}

TEST_F(DrivingLeasesTest, WhoeverStopsARobotIsNotRefused) {
  change(console_, LeaseVerb::kTake);
  EXPECT_EQ(command(tool_, kTool, kChassis, kMove, Bytes(12)), Outcome::kDelivered);
  EXPECT_EQ(command(tool_, kTool, kPilot, kHold), Outcome::kDelivered);
  EXPECT_EQ(command(tool_, kTool, kPilot, type::kOff), Outcome::kDelivered);
  for (const std::uint8_t order : {std::uint8_t{0}, flag::kBodyLittleEndian}) {
    Bytes none(4, std::byte{0xFF});
    none[order == 0 ? 3 : 0] = std::byte{0};
    EXPECT_EQ(send(tool_, {.flags = order, .type = kSetActivePilot, .dest = kChassis, .src = kTool},
                   none),
              Outcome::kDelivered);
  }
  EXPECT_EQ(command(tool_, kTool, kChassis, kSetActivePilot, Bytes(3, std::byte{0xFF})),
            Outcome::kNoLease)
      << "too short";
}

TEST_F(DrivingLeasesTest, AStickThatIsNotTheHoldersIsRefused) {
  change(console_, LeaseVerb::kTake);
  router_.register_mailbox(now_, tool_, kOtherStick);
  EXPECT_EQ(command(tool_, kOtherStick, kPilot, type::kData), Outcome::kNoLease);
  EXPECT_EQ(command(tool_, kOtherStick, kPilot, type::kData, Bytes(20)), Outcome::kDelivered)
      << "at rest";
  EXPECT_TRUE(sink_.replies.empty()) << "data are not answered";
}

TEST_F(DrivingLeasesTest, AForgedSourceIsNotTheHolders) {
  change(console_, LeaseVerb::kTake);
  EXPECT_EQ(command(tool_, kConsole, kChassis, kMove), Outcome::kNoLease);
  EXPECT_EQ(command(tool_, kPilot, kChassis, kMove), Outcome::kNoLease) << "not the robot's pilot";
}

TEST_F(DrivingLeasesTest, BehindALinkTheHolderIsItsMailboxAndItsStick) {
  router_.disconnect(now_, console_, CloseReason::kPeerClosed);
  const ClientId base = link(LinkKind::kSuper, 0, "base");
  ASSERT_EQ(change(base, LeaseVerb::kTake, "desk", Address(0x00020505)), LeaseResult::kDone);
  EXPECT_EQ(command(base, Address(0x00020505), kPilot, kSetDestination), Outcome::kDelivered);
  EXPECT_EQ(command(base, kStick, kPilot, type::kData), Outcome::kDelivered);
  EXPECT_EQ(command(base, Address(0x00020606), kPilot, kSetDestination), Outcome::kNoLease);
  EXPECT_EQ(change(base, LeaseVerb::kTake, "other desk", Address(0x00020606)), LeaseResult::kTaken);
}

TEST_F(DrivingLeasesTest, ALeaseIsTakenOverOnlyExplicitly) {
  change(console_, LeaseVerb::kTake);
  EXPECT_EQ(change(tool_, LeaseVerb::kTake, "desk"), LeaseResult::kTaken);
  EXPECT_EQ(change(tool_, LeaseVerb::kRenew, "desk"), LeaseResult::kNotHeld);
  EXPECT_EQ(change(tool_, LeaseVerb::kRelease, "desk"), LeaseResult::kNotHeld);
  EXPECT_EQ(change(tool_, LeaseVerb::kTakeOver, "desk"), LeaseResult::kDone);
  EXPECT_EQ(router_.leases().find(3)->holder.view(), "desk");
  EXPECT_EQ(count(EventKind::kLeaseTaken), 2U);
  EXPECT_EQ(count(EventKind::kLeaseEnded), 1U);
  EXPECT_EQ(command(console_, kConsole, kPilot, kSetDestination), Outcome::kNoLease);
  EXPECT_EQ(change(console_, LeaseVerb::kRenew), LeaseResult::kNotHeld);
}

TEST_F(DrivingLeasesTest, ALeaseEndsWhenItIsReleased) {
  change(console_, LeaseVerb::kTake);
  EXPECT_EQ(change(console_, LeaseVerb::kRelease), LeaseResult::kDone);
  EXPECT_EQ(tool_moves(), Outcome::kDelivered);
  EXPECT_EQ(router_.next_timeout(), kNever);
}

TEST_F(DrivingLeasesTest, ALeaseEndsWithItsConnection) {
  change(console_, LeaseVerb::kTake);
  router_.disconnect(now_, console_, CloseReason::kConnectionLost);
  EXPECT_EQ(sink_.events[sink_.events.size() - 2].kind, EventKind::kLeaseEnded);
  EXPECT_EQ(tool_moves(), Outcome::kDelivered);
}

TEST_F(DrivingLeasesTest, ALeaseEndsWhenItIsNotRenewed) {
  change(console_, LeaseVerb::kTake);
  const Time began = now_;
  pass(DrivingLeases::kTime - 1ms);
  EXPECT_EQ(change(console_, LeaseVerb::kRenew), LeaseResult::kDone);
  EXPECT_EQ(router_.leases().find(3)->since, began);
  EXPECT_EQ(router_.next_timeout(), now_ + DrivingLeases::kTime);
  pass(DrivingLeases::kTime - 1ms);
  EXPECT_EQ(tool_moves(), Outcome::kNoLease);
  pass(1ms);
  EXPECT_EQ(tool_moves(), Outcome::kDelivered);
  EXPECT_EQ(change(console_, LeaseVerb::kRenew), LeaseResult::kNotHeld);
}

TEST_F(DrivingLeasesTest, TheirNumberIsBounded) {
  DrivingLeases leases;
  DrivingLease wanted{.client = {.id = {1}}};
  for (; wanted.robot < DrivingLeases::kLeasesMax; ++wanted.robot)
    ASSERT_EQ(leases.change(now_, LeaseVerb::kTake, wanted).result, LeaseResult::kDone);
  EXPECT_EQ(leases.change(now_, LeaseVerb::kTake, wanted).result, LeaseResult::kTooMany);
  wanted.robot = 0;
  EXPECT_EQ(leases.change(now_, LeaseVerb::kTake, wanted).result, LeaseResult::kDone) << "its own";
}

}  // namespace driving_leases_test
}  // namespace tims::core::test

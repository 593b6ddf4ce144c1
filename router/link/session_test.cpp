// One session by itself: packets by hand, and what it says to them. What two sessions do with each
// other is in tests/sim.
#include "router/link/session.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

using namespace std::chrono_literals;

struct Nobody final : Arrivals, Losses {
  void on_message(Time, const RecordPrefix&, core::Message&) override {}
  void on_control(Time, const core::Message&) override {}
  void on_frame(Time, const KeepAlive&) override {}
  void on_frame(Time, const ChallengeFrame&) override {}
  void on_frame(Time, const ResponseFrame&) override {}
  void on_frame(Time, const CloseFrame&) override {}
  void on_lost(Time, const Header&, core::Outcome) override {}
};

struct SessionTest : testing::Test {
  // A packet that wants an acknowledgement and has nothing else in it.
  void receive(std::uint32_t packet) {
    std::array frames{static_cast<std::byte>(FrameType::kProbe)};
    ASSERT_TRUE(session.is_new(packet));
    ASSERT_EQ(session.on_data(now, {.header = {.packet = packet}, .frames = frames}),
              Session::Verdict::kTaken);
  }
  // The ranges of the acknowledgement that is sent now; none: nothing is.
  std::size_t acknowledged_ranges() {
    std::array<std::byte, kDatagramMax> datagram{};
    const std::size_t size = session.build(now, 1, datagram);
    if (size == 0) return 0;
    FrameReader reader{std::span(datagram).first(size).subspan(kDataHeaderSize)};
    const auto frame = reader.next();
    const auto* ack = frame ? std::get_if<Ack>(&*frame) : nullptr;
    return ack == nullptr ? 0 : ack->count;
  }

  core::BlockPool pool{{}};
  MessageMemory memory{{}};
  std::vector<MessageBuffer> done;
  Nobody nobody;
  Session session{pool, memory, done, SessionSettings(), nobody, nobody};
  Time now{100s};
};

TEST_F(SessionTest, EverySecondPacketIsAcknowledgedAtOnce) {
  receive(0);
  EXPECT_EQ(acknowledged_ranges(), 0U);
  receive(1);
  EXPECT_EQ(acknowledged_ranges(), 1U);
  receive(2);
  EXPECT_EQ(acknowledged_ranges(), 0U);
}

TEST_F(SessionTest, OnePacketAloneIsAcknowledgedAfterAMoment) {
  receive(0);
  EXPECT_EQ(session.next_timeout(now), now + RttEstimator::kAckDelayMax);
  now += RttEstimator::kAckDelayMax;
  session.on_timeout(now);
  EXPECT_EQ(acknowledged_ranges(), 1U);
}

// The other side is to learn of the gap soon, and soon that there is none.
TEST_F(SessionTest, APacketOutOfOrderIsAcknowledgedAtOnce) {
  receive(1);
  EXPECT_EQ(acknowledged_ranges(), 1U) << "after a gap";
  receive(3);
  EXPECT_EQ(acknowledged_ranges(), 2U) << "after another one";
  receive(0);
  EXPECT_EQ(acknowledged_ranges(), 2U) << "late";
  receive(4);
  EXPECT_EQ(acknowledged_ranges(), 0U) << "in order: there is time";
}

}  // namespace
}  // namespace tims::link

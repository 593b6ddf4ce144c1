// Tests of one session with hand-made packets. Tests of two sessions are in tests/sim.
#include "router/link/link_session.h"

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::link {
namespace link_session_test {

using namespace std::chrono_literals;

struct Nobody : ArrivalObserver, LossObserver {
  void on_message(Time, const RecordPrefix&, core::Message&) override {}
  void on_control(Time, const core::Message&) override {}
  void on_frame(Time, const KeepAlive&) override {}
  void on_frame(Time, const ChallengeFrame&) override {}
  void on_frame(Time, const ResponseFrame&) override {}
  void on_frame(Time, const CloseFrame&) override {}
  void on_frame(Time, const PauseFrame&) override {}
  void on_lost(Time, const Header&, core::Outcome) override {}
};

struct LinkSessionTest : testing::Test {
  // A packet that only requests an acknowledgement.
  void receive(std::uint32_t packet) {
    std::array frames{static_cast<std::byte>(FrameType::kProbe)};
    ASSERT_TRUE(session.is_new(packet));
    ASSERT_EQ(session.on_data(now, {.header = {.packet = packet}, .frames = frames}),
              LinkSession::Verdict::kTaken);
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
  MessageMemory memory{{}, 1U << 16, 1U << 18};
  std::vector<MessageBuffer> done;
  Nobody nobody;
  LinkSession session{pool, memory, done, LinkSessionSettings(), nobody, nobody};
  Time now{100s};
};

TEST_F(LinkSessionTest, EverySecondPacketIsAcknowledgedAtOnce) {
  receive(0);
  EXPECT_EQ(acknowledged_ranges(), 0U);
  receive(1);
  EXPECT_EQ(acknowledged_ranges(), 1U);
  receive(2);
  EXPECT_EQ(acknowledged_ranges(), 0U);
}

TEST_F(LinkSessionTest, OnePacketAloneIsAcknowledgedAfterAMoment) {
  receive(0);
  EXPECT_EQ(session.next_timeout(now), now + RttEstimator::kAckDelayMax);
  now += RttEstimator::kAckDelayMax;
  session.on_timeout(now);
  EXPECT_EQ(acknowledged_ranges(), 1U);
}

// The other side is to learn of the gap soon, and soon that there is none.
TEST_F(LinkSessionTest, APacketOutOfOrderIsAcknowledgedAtOnce) {
  receive(1);
  EXPECT_EQ(acknowledged_ranges(), 1U) << "after a gap";
  receive(3);
  EXPECT_EQ(acknowledged_ranges(), 2U) << "after another one";
  receive(0);
  EXPECT_EQ(acknowledged_ranges(), 2U) << "late";
  receive(4);
  EXPECT_EQ(acknowledged_ranges(), 0U) << "in order: there is time";
}

struct FullQueueTest : testing::Test {
  struct Losses final : Nobody {
    void on_lost(Time, const Header&, core::Outcome) override { ++lost; }
    int lost = 0;
  };
  core::Outcome send(std::uint8_t priority, std::size_t size) {
    const std::vector<std::byte> bytes(size);
    const Header header{.priority = priority, .length = static_cast<std::uint32_t>(size)};
    std::vector<std::byte> message(bytes);
    wire::encode_header(header, std::span(message).first<kHeaderSize>());
    return session.send(now, {}, header, message);
  }
  static constexpr std::uint64_t kMax = 400'000;
  alignas(core::BlockPool::kBlockSize) std::array<std::byte, 4U << 20> blocks{};
  core::BlockPool pool{blocks};
  MessageMemory memory{{}, 1U << 16, 1U << 18};
  std::vector<MessageBuffer> done;
  Losses losses;
  LinkSession session{pool, memory, done, {.queue_bytes_max = kMax}, losses, losses};
  Time now{100s};
};

TEST_F(FullQueueTest, NothingIsDroppedForWhatHasNoRoomAllTheSame) {
  // In flight, or more important: it stays.
  while (session.queued_bytes() < kMax - 60'000)
    ASSERT_EQ(send(255, 20'000), core::Outcome::kDelivered);
  ASSERT_EQ(session.queued_bytes(1), 0U);
  while (session.queued_bytes() < kMax - 22'000)
    ASSERT_EQ(send(0, 1'000), core::Outcome::kDelivered);
  const std::uint64_t before = session.queued_bytes();
  EXPECT_EQ(send(100, 300'000), core::Outcome::kQueueFull);
  EXPECT_EQ(losses.lost, 0);
  EXPECT_EQ(session.queued_bytes(), before);
}

TEST_F(FullQueueTest, NoMoreIsDroppedThanIsNeeded) {
  while (session.queued_bytes() < kMax - 20'000)
    ASSERT_EQ(send(0, 20'000), core::Outcome::kDelivered);
  EXPECT_EQ(send(100, 30'000), core::Outcome::kDelivered);
  EXPECT_LE(losses.lost, 2);
}

}  // namespace link_session_test
}  // namespace tims::link

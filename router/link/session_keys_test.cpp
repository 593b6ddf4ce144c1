#include "router/link/session_keys.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace session_keys_test {

using namespace std::chrono_literals;

// The tag names secret, phase and number.
class NamingSealer final : public Sealer {
 public:
  explicit NamingSealer(std::uint8_t secret) : secret_(secret) {}
  void seal(std::uint64_t number, std::span<const std::byte>, std::span<std::byte>,
            std::span<std::byte, kTagSize> tag) override {
    ByteWriter(tag).put(secret_, sending_, number);
  }
  bool open(Phase phase, std::uint64_t number, std::span<const std::byte>, std::span<std::byte>,
            std::span<const std::byte, kTagSize> tag) override {
    const int step = phase == Phase::kFormer ? -1 : phase == Phase::kNext ? 1 : 0;
    ByteReader in(tag);
    return in.get<std::uint8_t>() == secret_ &&
           in.get<std::uint32_t>() == receiving_ + static_cast<std::uint32_t>(step) &&
           in.get<std::uint64_t>() == number;
  }
  void next_sending_phase() override { ++sending_; }
  void next_receiving_phase() override { ++receiving_; }
  [[nodiscard]] std::string_view suite() const override { return "names"; }

 private:
  std::uint8_t secret_;
  std::uint32_t sending_ = 0;
  std::uint32_t receiving_ = 0;
};

std::unique_ptr<Sealer> sealer(std::uint8_t secret) {
  return std::make_unique<NamingSealer>(secret);
}

class SessionKeysTest : public testing::Test {
 protected:
  using Verdict = SessionKeys::Verdict;
  using Datagram = std::array<std::byte, kDataHeaderSize + 1 + Sealer::kTagSize>;
  SessionKeysTest() {
    ours.begin(now, sealer(1));
    theirs.begin(now, sealer(1));
  }
  Datagram seal(std::uint64_t packet) {
    Datagram datagram{};
    ours.seal(now, 77, packet, datagram);
    return datagram;
  }
  Verdict open(Datagram datagram, std::uint64_t packet) {
    auto data = decode_data(datagram);
    const Verdict verdict = theirs.open(now, packet, *data);
    if (verdict == Verdict::kOpened) {
      EXPECT_EQ(data->frames.size(), 1U);
    }
    return verdict;
  }

  Time now{100s};
  SessionKeys ours;
  SessionKeys theirs;
};

TEST(PlainSession, OpensEverythingAndAddsNothing) {
  SessionKeys none;
  EXPECT_EQ(none.overhead(), 0U);
  std::array<std::byte, kDataHeaderSize + 1> datagram{};
  none.seal({}, 77, 5, datagram);
  auto data = decode_data(datagram);
  ASSERT_TRUE(data);
  EXPECT_EQ(data->header.token, 77U);
  EXPECT_EQ(none.open({}, 5, *data), SessionKeys::Verdict::kOpened);
  EXPECT_EQ(data->frames.size(), 1U);
}

TEST_F(SessionKeysTest, APhaseEndsAfterItsTimeAndTheFormerOneStaysForAWhile) {
  const Datagram before = seal(1);
  now += SessionKeys::kPhaseMax;
  const Datagram after = seal(3);
  EXPECT_EQ(ours.sending_phase(), 1);
  EXPECT_EQ(open(after, 3), Verdict::kOpened);
  EXPECT_EQ(open(before, 1), Verdict::kOpened);
  EXPECT_EQ(open(before, 4), Verdict::kOldKey) << "sent later, so not under a former key";
  now += SessionKeys::kFormerFor;
  EXPECT_EQ(open(before, 1), Verdict::kOldKey);
  EXPECT_EQ(open(after, 3), Verdict::kOpened);
}

TEST_F(SessionKeysTest, APhaseEndsAfterItsNumberOfPackets) {
  for (std::uint64_t n = 0; n < SessionKeys::kPacketsMax; ++n) (void)seal(n);
  EXPECT_EQ(ours.sending_phase(), 0);
  const Datagram first = seal(SessionKeys::kPacketsMax);
  EXPECT_EQ(ours.sending_phase(), 1);
  EXPECT_EQ(open(first, SessionKeys::kPacketsMax), Verdict::kOpened);
}

// Phases are one byte on the wire.
TEST_F(SessionKeysTest, PhasesGoRound) {
  for (std::uint64_t n = 0; n < 600; ++n) {
    now += SessionKeys::kPhaseMax;
    ASSERT_EQ(open(seal(n), n), Verdict::kOpened) << n;
  }
}

TEST_F(SessionKeysTest, OfOtherPhasesAndGenerationsNothingOpens) {
  Datagram datagram = seal(1);
  for (int phase = 2; phase < 255; ++phase) {
    datagram[1] = static_cast<std::byte>(phase);
    EXPECT_EQ(open(datagram, 1), Verdict::kOldKey);
  }
  datagram[1] = std::byte{1};
  EXPECT_EQ(open(datagram, 1), Verdict::kForged);
  datagram[1] = std::byte{0};
  datagram[2] = std::byte{1};
  EXPECT_EQ(open(datagram, 1), Verdict::kOldKey);
}

TEST_F(SessionKeysTest, TooShortForATagIsForged) {
  std::array<std::byte, kDataHeaderSize + Sealer::kTagSize - 1> datagram{std::byte{1}};
  auto data = decode_data(datagram);
  ASSERT_TRUE(data);
  EXPECT_EQ(theirs.open(now, 1, *data), Verdict::kForged);
}

// The side that has been called uses new keys once it has received something under them.
TEST_F(SessionKeysTest, BothSidesTurnToNewKeysWithoutAGap) {
  EXPECT_EQ(theirs.next_generation(), 1);
  const Datagram old = seal(1);
  theirs.renew(now, 1, sealer(2), false);
  EXPECT_EQ(theirs.generation(), 0);
  EXPECT_EQ(theirs.next_generation(), 2);
  ours.renew(now, 1, sealer(2), true);
  EXPECT_EQ(ours.generation(), 1);
  EXPECT_EQ(open(seal(2), 2), Verdict::kOpened);
  EXPECT_EQ(theirs.generation(), 1);
  EXPECT_EQ(open(old, 1), Verdict::kOpened) << "overtaken";
  now += SessionKeys::kFormerFor;
  EXPECT_EQ(open(old, 1), Verdict::kOldKey);
}

}  // namespace session_keys_test
}  // namespace tims::link

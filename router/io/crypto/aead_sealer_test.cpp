#include "router/io/crypto/aead_sealer.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "base/text.h"
#include "router/link/frame.h"

namespace tims::io {
namespace aead_sealer_test {

using Phase = link::Sealer::Phase;
using security::Suite;

AeadSealer::Secret secret(std::uint8_t first) {
  AeadSealer::Secret bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>(first + static_cast<std::uint8_t>(i));
  return bytes;
}

struct Datagram {
  std::array<std::byte, 16> header{std::byte{1}, std::byte{2}};
  std::array<std::byte, 5> text{std::byte{'h'}, std::byte{'e'}, std::byte{'l'}, std::byte{'l'},
                                std::byte{'o'}};
  std::array<std::byte, 16> tag{};

  void seal(AeadSealer& with, std::uint64_t number) { with.seal(number, header, text, tag); }
  [[nodiscard]] bool opens(AeadSealer& with, Phase phase, std::uint64_t number) const {
    Datagram copy = *this;
    return with.open(phase, number, copy.header, copy.text, copy.tag) &&
           copy.text == Datagram{}.text;
  }
};

class AeadSealerTest : public testing::TestWithParam<Suite> {
 protected:
  AeadSealer ours{GetParam(), secret(1), secret(2)};
  AeadSealer theirs{GetParam(), secret(2), secret(1)};
};

TEST_P(AeadSealerTest, WhatIsSealedOpensAtTheOtherSideOnly) {
  Datagram sent;
  sent.seal(ours, 7);
  EXPECT_NE(sent.text, Datagram{}.text);
  EXPECT_TRUE(sent.opens(theirs, Phase::kCurrent, 7));
  EXPECT_FALSE(sent.opens(theirs, Phase::kCurrent, 8));
  EXPECT_FALSE(sent.opens(theirs, Phase::kCurrent, 7 + (std::uint64_t{1} << 32)));
  EXPECT_FALSE(sent.opens(theirs, Phase::kNext, 7));
  EXPECT_FALSE(sent.opens(theirs, Phase::kFormer, 7)) << "there is none yet";
  EXPECT_FALSE(sent.opens(ours, Phase::kCurrent, 7)) << "reflected";
}

TEST_P(AeadSealerTest, EveryBitIsAuthenticated) {
  Datagram sent;
  sent.seal(ours, 7);
  const auto flipped = [&](auto member, std::size_t bit) {
    Datagram other = sent;
    (other.*member)[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    return other.opens(theirs, Phase::kCurrent, 7);
  };
  for (std::size_t bit = 0; bit < 128; ++bit) {
    EXPECT_FALSE(flipped(&Datagram::header, bit));
    EXPECT_FALSE(flipped(&Datagram::tag, bit));
    if (bit < 40) {
      EXPECT_FALSE(flipped(&Datagram::text, bit));
    }
  }
}

TEST_P(AeadSealerTest, PhasesFollowEachOther) {
  for (int phase = 0; phase < 5; ++phase) {
    Datagram before;
    before.seal(ours, 10);
    ours.next_sending_phase();
    Datagram after;
    after.seal(ours, 11);
    EXPECT_FALSE(after.opens(theirs, Phase::kCurrent, 11));
    EXPECT_TRUE(after.opens(theirs, Phase::kNext, 11));
    theirs.next_receiving_phase();
    EXPECT_TRUE(after.opens(theirs, Phase::kCurrent, 11));
    EXPECT_TRUE(before.opens(theirs, Phase::kFormer, 10));
    EXPECT_FALSE(before.opens(theirs, Phase::kCurrent, 10));
  }
}

INSTANTIATE_TEST_SUITE_P(Suites, AeadSealerTest,
                         testing::Values(Suite::kAes128Gcm, Suite::kChaCha20Poly1305));

// Known answer, which stands in PROTOCOL.md: two bytes of lane 7 in packet 5.
TEST(SealedDatagram, OfTheDocument) {
  AeadSealer sealer(Suite::kAes128Gcm, secret(0), secret(0));
  std::array<std::byte, 14> frame{std::byte{3}, std::byte{7}, std::byte{2}};
  frame[12] = std::byte{0xAB};
  frame[13] = std::byte{0xCD};
  std::array<std::byte, 16> header{};
  link::encode({.token = 0x1122334455667788, .packet = 5}, header);
  std::array<std::byte, 16> tag{};
  sealer.seal(5, header, frame, tag);
  EXPECT_EQ(base::to_hex(header), "01000000050000008877665544332211");
  EXPECT_EQ(base::to_hex(frame), "230a2a938f86f4bc4fbdec7edf5a");
  EXPECT_EQ(base::to_hex(tag), "824683d666c1f8f630c55f17d95e85dd");
}

}  // namespace aead_sealer_test
}  // namespace tims::io

#include "wire/header.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

namespace tims::wire {
namespace header_test {

using Bytes = std::array<std::byte, kHeaderSize>;

template <typename... Ints>
constexpr Bytes bytes_of(Ints... values) {
  return {static_cast<std::byte>(values)...};
}

Header sample(std::uint8_t flags) {
  return {.flags = flags,
          .type = -6,
          .priority = 200,
          .seq_nr = 0x42,
          .dest = Address(0x03140002),
          .src = Address(0x80112233),
          .length = 0x00012345};
}

constexpr Bytes kLittle = bytes_of(0x01, 0xfa, 200, 0x42, 0x02, 0x00, 0x14, 0x03,  //
                                   0x33, 0x22, 0x11, 0x80, 0x45, 0x23, 0x01, 0x00);
constexpr Bytes kBig = bytes_of(0x00, 0xfa, 200, 0x42, 0x03, 0x14, 0x00, 0x02,  //
                                0x80, 0x11, 0x22, 0x33, 0x00, 0x01, 0x23, 0x45);

Bytes with_flags(Bytes bytes, std::uint8_t flags) {
  bytes[0] = static_cast<std::byte>(flags);
  return bytes;
}

TEST(Header, DecodesAllFourOrderCombinations) {
  EXPECT_EQ(decode_header(with_flags(kBig, 0)), sample(0));
  EXPECT_EQ(decode_header(with_flags(kLittle, 1)), sample(1));
  EXPECT_EQ(decode_header(with_flags(kBig, 2)), sample(2));
  EXPECT_EQ(decode_header(with_flags(kLittle, 3)), sample(3));
  EXPECT_EQ(sample(0).body_order(), std::endian::big);
  EXPECT_EQ(sample(1).body_order(), std::endian::big);
  EXPECT_EQ(sample(2).body_order(), std::endian::little);
  EXPECT_EQ(sample(3).body_order(), std::endian::little);
}

TEST(Header, EncodeChoosesTheByteOrderAndKeepsAllOtherFlags) {
  for (int flags = 0; flags < 256; ++flags) {
    const Header header = sample(static_cast<std::uint8_t>(flags));
    Bytes bytes{};
    encode_header(header, bytes, std::endian::little);
    EXPECT_EQ(bytes, with_flags(kLittle, static_cast<std::uint8_t>(flags | 1)));
    encode_header(header, bytes, std::endian::big);
    EXPECT_EQ(bytes, with_flags(kBig, static_cast<std::uint8_t>(flags & 0xfe)));
  }
}

TEST(Header, EncodesInTheMachinesOrderByDefault) {
  Bytes bytes{};
  encode_header(sample(0), bytes);
  EXPECT_EQ(decode_header(bytes).flags, flag::kNativeOrder & flag::kHeaderLittleEndian);
}

// Any 16 bytes are the same after decoding and encoding in their own order.
TEST(Header, EverySixteenBytesSurviveARoundTrip) {
  std::mt19937 random(1);
  for (int round = 0; round < 20000; ++round) {
    Bytes bytes{};
    for (std::byte& b : bytes) b = static_cast<std::byte>(random());
    const Header header = decode_header(bytes);
    const bool little = (header.flags & flag::kHeaderLittleEndian) != 0;
    Bytes again{};
    encode_header(header, again, little ? std::endian::little : std::endian::big);
    ASSERT_EQ(again, bytes);
  }
}

TEST(CheckLength, Limits) {
  EXPECT_EQ(check_length(0, 100), LengthVerdict::kTooShort);
  EXPECT_EQ(check_length(15, 100), LengthVerdict::kTooShort);
  EXPECT_EQ(check_length(16, 100), LengthVerdict::kOk);
  EXPECT_EQ(check_length(100, 100), LengthVerdict::kOk);
  EXPECT_EQ(check_length(101, 100), LengthVerdict::kTooLong);
  EXPECT_EQ(check_length(0xffffffff, 100), LengthVerdict::kTooLong);
}

TEST(ReplyTo, SwapsAddressesAndKeepsPriorityAndSequenceNumber) {
  const Header request = sample(0);
  const Header reply = reply_to(request, type::kOk, 4);
  EXPECT_EQ(reply.dest, request.src);
  EXPECT_EQ(reply.src, request.dest);
  EXPECT_EQ(reply.priority, request.priority);
  EXPECT_EQ(reply.seq_nr, request.seq_nr);
  EXPECT_EQ(reply.type, type::kOk);
  EXPECT_EQ(reply.length, 20U);
  EXPECT_EQ(reply.flags, flag::kNativeOrder);
}

}  // namespace header_test
}  // namespace tims::wire

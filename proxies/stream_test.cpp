#include "proxies/stream.h"

#include <array>

#include <gtest/gtest.h>

#include "proxies/generic.h"

namespace rack {
namespace {

using tims::Address;
using tims::Errc;

constexpr Address kProducer(0x00140000);

struct Number {
  u32 value = 0;
};

tims::MessageView message(i8 type, std::span<const std::byte> body, Address src = kProducer) {
  return {{.flags = 0, .type = type, .src = src}, body};
}

TEST(Stream, DecodesInTheOrderOfTheHeader) {
  std::array<std::byte, 4> body{};
  body[3] = std::byte{5};
  Number number;
  ASSERT_TRUE(decode_data(message(-6, body), kProducer, number));
  EXPECT_EQ(number.value, 5U);
}

TEST(Stream, EndIsToldFromRubbish) {
  const std::array<std::byte, 4> body{};
  Number number;
  const auto code = [&](const tims::MessageView& m) {
    return decode_data(m, kProducer, number).error().code();
  };
  EXPECT_EQ(code(message(-1, {})), Errc::kAnsweredError);
  EXPECT_EQ(code(message(0, body)), Errc::kInvalidArgument);
  EXPECT_EQ(code(message(-6, body, Address(0x00150000))), Errc::kInvalidArgument);
  EXPECT_EQ(code(message(-6, std::span(body).first(3))), Errc::kMalformed);
}

TEST(Status, HasAWord) {
  EXPECT_EQ(name(Status::kEnabled), "enabled");
  EXPECT_EQ(name(Status::kDisabled), "disabled");
  EXPECT_EQ(name(Status::kError), "error");
}

}  // namespace
}  // namespace rack

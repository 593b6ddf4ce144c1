#include "components/joystick/sticks.h"

#include <cstring>
#include <vector>

#include <gtest/gtest.h>

namespace rack::joystick {

namespace sticks_test {

std::vector<std::byte> event(i16 value, u8 type, u8 number) {
  std::vector<std::byte> bytes(8);
  std::memcpy(&bytes[4], &value, sizeof value);
  bytes[6] = std::byte(type);
  bytes[7] = std::byte(number);
  return bytes;
}

TEST(JsEvents, Axes) {
  JsEvents stick({});
  stick.push(event(-32767, 2, 1));
  stick.push(event(16384, 2, 0));
  stick.push(event(-32768, 2, 2));
  EXPECT_EQ(stick.position().x, 100) << "forward";
  EXPECT_EQ(stick.position().y, 50) << "to the right";
  EXPECT_EQ(stick.position().z, -100);
  stick.push(event(1000, 2, 0));
  EXPECT_EQ(stick.position().y, 0) << "nearly in the middle";
}

TEST(JsEvents, Buttons) {
  JsEvents stick({});
  stick.push(event(1, 1 | 0x80, 0));
  stick.push(event(1, 1, 31));
  stick.push(event(1, 1, 32));
  EXPECT_EQ(stick.buttons(), static_cast<i32>(0x80000001));
  stick.push(event(0, 1, 0));
  EXPECT_EQ(stick.buttons(), static_cast<i32>(0x80000000));
  stick.release();
  EXPECT_EQ(stick.buttons(), 0);
}

TEST(JsEvents, ComeInPieces) {
  JsEvents stick({});
  const auto bytes = event(32767, 2, 0);
  for (const std::byte byte : bytes) {
    EXPECT_EQ(stick.position().y, 0);
    stick.push({&byte, 1});
  }
  EXPECT_EQ(stick.position().y, 100);
}

TEST(JsEvents, OtherAxesAndNone) {
  JsEvents stick({.x = 255, .y = -1, .z = 300});
  stick.push(event(32767, 2, 255));
  stick.push(event(32767, 2, 0));
  EXPECT_EQ(stick.position().x, -100);
  EXPECT_EQ(stick.position().y, 0);
  EXPECT_EQ(stick.position().z, 0);
}

TEST(JsEvents, OfUnknownTypesAreLeftOut) {
  JsEvents stick({});
  stick.push(event(32767, 7, 0));
  EXPECT_EQ(stick.position().y, 0);
  EXPECT_EQ(stick.buttons(), 0);
}

}  // namespace sticks_test

namespace sticks_test {

TEST(KeyboardStick, LettersMoveIt) {
  KeyboardStick stick;
  stick.push("wwwsaad");
  EXPECT_EQ(stick.position().x, 20);
  EXPECT_EQ(stick.position().y, -10);
  stick.push(" ");
  EXPECT_EQ(stick.position().x, 0);
  EXPECT_EQ(stick.position().y, 0);
}

TEST(KeyboardStick, ArrowsMoveIt) {
  KeyboardStick stick;
  stick.push("\x1b[A\x1b[A\x1b[C");
  EXPECT_EQ(stick.position().x, 20);
  EXPECT_EQ(stick.position().y, 10);
  stick.push("\x1b");
  stick.push("O");
  stick.push("B");
  EXPECT_EQ(stick.position().x, 10);
  stick.push("\x1b[D");
  EXPECT_EQ(stick.position().y, 0);
}

TEST(KeyboardStick, ItHasAnEnd) {
  KeyboardStick stick;
  for (int i = 0; i < 20; ++i) stick.push("wa");
  EXPECT_EQ(stick.position().x, 100);
  EXPECT_EQ(stick.position().y, -100);
}

TEST(KeyboardStick, DigitsAreButtons) {
  KeyboardStick stick;
  stick.push("039");
  EXPECT_EQ(stick.buttons(), 1 | 8 | 512);
  stick.push("3");
  EXPECT_EQ(stick.buttons(), 1 | 512);
}

TEST(KeyboardStick, AnyOtherKeyStops) {
  for (const char* keys : {"x", "\n", "\x1b[Z", "\x1bx"}) {
    KeyboardStick stick;
    stick.push("ww0");
    stick.push(keys);
    EXPECT_EQ(stick.position().x, 0) << keys;
    EXPECT_EQ(stick.buttons(), 0) << keys;
  }
}

}  // namespace sticks_test

}  // namespace rack::joystick

#include "components/joystick/keyboard_stick.h"

#include <gtest/gtest.h>

namespace rack::joystick {
namespace {

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

}  // namespace
}  // namespace rack::joystick

// A stick made of keys, for who has no other: each press moves it by a tenth. Pure.
//
//   w, s or up, down     forward, backward        0 to 9   button on, off
//   a, d or left, right  to the left, right       others   all in the middle, no button
#pragma once

#include <string_view>

#include "rack/proxies/joystick.h"

namespace rack::joystick {

class KeyboardStick {
 public:
  // What the terminal says; keys that are several characters come whole or in pieces.
  void push(std::string_view characters);

  [[nodiscard]] const JoystickAxes& position() const { return position_; }
  [[nodiscard]] i32 buttons() const { return buttons_; }

 private:
  void key(char key);
  void escape(char part);

  JoystickAxes position_;
  i32 buttons_ = 0;
  enum class Escape : std::uint8_t { kNone, kBegun, kBracket } escape_ = Escape::kNone;
};

}  // namespace rack::joystick

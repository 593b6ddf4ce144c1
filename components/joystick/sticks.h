// Sticks: what a device of Linux and what keys of a terminal say, as positions. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "rack/proxies/joystick.h"

namespace rack::joystick {

// --- The bytes of a Linux joystick device (/dev/input/js0) as a stick (linux/joystick.h).

// Which of the device's axes is which of ours; -1: none.
struct AxisMap {
  i32 x = 1;  // devices count backwards as positive, we forward
  i32 y = 0;
  i32 z = 2;
  i32 dead_zone = 5;  // %, around the middle: few sticks come back to it
};

class JsEvents {
 public:
  explicit JsEvents(const AxisMap& axes) : axes_(axes) {}

  // As they come: an event may be cut anywhere.
  void push(std::span<const std::byte> bytes);
  void release();  // all in the middle, no button down

  [[nodiscard]] JoystickAxes position() const;
  [[nodiscard]] i32 buttons() const { return static_cast<i32>(buttons_); }

 private:
  static constexpr std::size_t kEventSize = 8;
  void event();
  [[nodiscard]] i32 percent(i32 axis) const;

  AxisMap axes_;
  std::array<std::byte, kEventSize> event_{};
  std::size_t size_ = 0;  // of what is there of the next event
  std::array<i16, 256> values_{};
  u32 buttons_ = 0;
};

// --- A stick made of keys, for who has no other: each press moves it by a tenth.
//
//   w, s or up, down     forward, backward        0 to 9   button on, off
//   a, d or left, right  to the left, right       others   all in the middle, no button

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

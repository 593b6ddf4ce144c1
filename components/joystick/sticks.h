// Converts the events of a Linux joystick device, or keys of a terminal, to positions of a stick.
// Pure.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "rack/proxies/joystick.h"

namespace rack::joystick {

// --- The bytes of a Linux joystick device (/dev/input/js0), see linux/joystick.h.

// The assignment of the device's axes; -1: none.
struct AxisMap {
  i32 x = 1;  // positive is backward at the device, forward here
  i32 y = 0;
  i32 z = 2;
  i32 dead_zone = 5;  // %, around the centre: few sticks return to it exactly
};

class JsEvents {
 public:
  explicit JsEvents(const AxisMap& axes) : axes_(axes) {}

  // Received bytes; an event may be split anywhere.
  void push(std::span<const std::byte> bytes);
  void release();  // all axes centred, no button pressed

  [[nodiscard]] JoystickAxes position() const;
  [[nodiscard]] i32 buttons() const { return static_cast<i32>(buttons_); }

 private:
  static constexpr std::size_t kEventSize = 8;
  void event();
  [[nodiscard]] i32 percent(i32 axis) const;

  AxisMap axes_;
  std::array<std::byte, kEventSize> event_{};
  std::size_t size_ = 0;  // received bytes of the next event
  std::array<i16, 256> values_{};
  u32 buttons_ = 0;
};

// --- A stick controlled by keys: each press moves it by a tenth.
//
//   w, s or up, down     forward, backward        0 to 9   button on, off
//   a, d or left, right  to the left, right       others   all centred, no button

class KeyboardStick {
 public:
  // Received characters; keys of several characters may be split anywhere.
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

// The bytes of a Linux joystick device (/dev/input/js0) as a stick (linux/joystick.h). Pure.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "rack/proxies/joystick.h"

namespace rack::joystick {

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

}  // namespace rack::joystick

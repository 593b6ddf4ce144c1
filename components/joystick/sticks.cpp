#include "components/joystick/sticks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace rack::joystick {

namespace {

// An event: time (4 bytes), value (2), type, number; in the byte order of the machine.
constexpr std::size_t kValue = 4;
constexpr std::size_t kType = 6;
constexpr std::size_t kNumber = 7;
constexpr u8 kButton = 0x01;
constexpr u8 kAxis = 0x02;
constexpr u8 kInit = 0x80;  // flag: initial state when the device is opened
constexpr u8 kButtons = 32;
constexpr double kDeflection = 32767;

}  // namespace

void JsEvents::push(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) {
    event_[size_++] = byte;
    if (size_ < kEventSize) continue;
    size_ = 0;
    event();
  }
}

void JsEvents::event() {
  i16 value = 0;
  std::memcpy(&value, &event_[kValue], sizeof value);
  const auto type = static_cast<u8>(static_cast<u8>(event_[kType]) & ~kInit);
  const auto number = static_cast<u8>(event_[kNumber]);
  if (type == kAxis) values_[number] = value;
  if (type == kButton && number < kButtons) {
    const u32 bit = 1U << number;
    buttons_ = value != 0 ? buttons_ | bit : buttons_ & ~bit;
  }
}

void JsEvents::release() {
  size_ = 0;
  values_ = {};
  buttons_ = 0;
}

JoystickAxes JsEvents::position() const {
  return {.x = -percent(axes_.x), .y = percent(axes_.y), .z = percent(axes_.z)};
}

i32 JsEvents::percent(i32 axis) const {
  if (axis < 0 || axis >= static_cast<i32>(values_.size())) return 0;
  const double part = values_[static_cast<std::size_t>(axis)] / kDeflection;
  const auto percent = static_cast<i32>(std::lround(std::clamp(part, -1.0, 1.0) * 100));
  return std::abs(percent) < axes_.dead_zone ? 0 : percent;
}

namespace {

constexpr char kEscape = '\x1b';
constexpr i32 kStep = 10;

void move(Percent<i32>& axis, i32 by) { axis = std::clamp(axis + by, -100, 100); }

}  // namespace

void KeyboardStick::push(std::string_view characters) {
  for (const char c : characters) {
    if (c == kEscape) {
      escape_ = Escape::kBegun;
    } else if (escape_ != Escape::kNone) {
      escape(c);
    } else {
      key(c);
    }
  }
}

// Arrow keys are ESC [ A to D, or ESC O A to D.
void KeyboardStick::escape(char part) {
  if (escape_ == Escape::kBegun && (part == '[' || part == 'O')) {
    escape_ = Escape::kBracket;
    return;
  }
  const bool arrow = escape_ == Escape::kBracket && part >= 'A' && part <= 'D';
  escape_ = Escape::kNone;
  key(arrow ? std::string_view("wsda")[static_cast<std::size_t>(part - 'A')] : ' ');
}

void KeyboardStick::key(char key) {
  switch (key) {
    case 'w':
      return move(position_.x, kStep);
    case 's':
      return move(position_.x, -kStep);
    case 'd':
      return move(position_.y, kStep);
    case 'a':
      return move(position_.y, -kStep);
    default:
      break;
  }
  if (key >= '0' && key <= '9') {
    buttons_ ^= 1 << (key - '0');
    return;
  }
  position_ = {};
  buttons_ = 0;
}

}  // namespace rack::joystick

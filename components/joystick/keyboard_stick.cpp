#include "components/joystick/keyboard_stick.h"

#include <algorithm>

namespace rack::joystick {
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

// Arrows are ESC [ A to D, or ESC O A to D.
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

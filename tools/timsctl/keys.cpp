#include "tools/timsctl/keys.h"

#include <array>
#include <string_view>

#include <unistd.h>

namespace timsctl {

Keys::Keys() {
  termios now{};
  if (::isatty(STDIN_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &now) != 0) return;
  before_ = now;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  now.c_cc[VMIN] = 0;
  now.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

Keys::~Keys() {
  if (before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
}

int Keys::descriptor() const { return before_ ? STDIN_FILENO : -1; }

Key Keys::read() const {
  std::array<char, 16> buffer{};
  const ssize_t size = ::read(STDIN_FILENO, buffer.data(), buffer.size());
  if (size == 0) return Key::kQuit;  // the terminal has gone
  const std::string_view text(buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  if (text == "q" || text == "Q") return Key::kQuit;
  if (text == "\033[D" || text == "<") return Key::kLeft;
  if (text == "\033[C" || text == ">") return Key::kRight;
  return Key::kNone;
}

}  // namespace timsctl

// Single keys from a terminal, without Enter and without echo, until this goes.
#pragma once

#include <optional>

#include <termios.h>

namespace timsctl {

enum class Key { kNone, kQuit, kLeft, kRight };

class Keys {
 public:
  Keys();  // does nothing when stdin is no terminal
  ~Keys();
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  // To wait on; -1 when there are no keys.
  [[nodiscard]] int descriptor() const;
  Key read() const;

 private:
  std::optional<termios> before_;
};

}  // namespace timsctl

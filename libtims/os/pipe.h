// A pipe: what is written at one end is read at the other.
#pragma once

#include <array>

#include <fcntl.h>

#include "os/file.h"

namespace tims::os {

struct Pipe {
  File read;
  File write;
};

// Neither end is passed on to programs that are started.
inline Result<Pipe> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return system_error("pipe");
  return Pipe{File(ends[0]), File(ends[1])};
}

}  // namespace tims::os

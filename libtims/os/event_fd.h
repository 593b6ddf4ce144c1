// An eventfd: a wake-up that an event loop can wait for. Between programs: waker.h, unless who made
// it is trusted by all.
#pragma once

#include <cstdint>

#include <sys/eventfd.h>
#include <sys/uio.h>

#include "os/file.h"

namespace tims::os {

inline Result<File> make_event_fd() {
  File file(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!file) return system_error("eventfd");
  return file;
}
inline void signal_event_fd(int fd) { ::eventfd_write(fd, 1); }
// Never waits: the descriptor's own flags can be changed by whoever shares it.
inline void drain_event_fd(int fd) {
  std::uint64_t value = 0;
  const iovec whole{&value, sizeof value};
  (void)::preadv2(fd, &whole, 1, -1, RWF_NOWAIT);
}

}  // namespace tims::os

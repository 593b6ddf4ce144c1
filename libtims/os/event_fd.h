// An eventfd: a wake-up that an event loop can wait for.
#pragma once

#include <sys/eventfd.h>

#include "os/file.h"

namespace tims::os {

inline Result<File> make_event_fd() {
  File file(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!file) return system_error("eventfd");
  return file;
}
inline void signal_event_fd(int fd) { ::eventfd_write(fd, 1); }
inline void drain_event_fd(int fd) {
  eventfd_t value = 0;
  ::eventfd_read(fd, &value);
}

}  // namespace tims::os

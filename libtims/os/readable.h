// Waiting until a descriptor can be read, and several as if they were one.
#pragma once

#include <algorithm>
#include <span>

#include <poll.h>
#include <sys/epoll.h>

#include "os/clock.h"
#include "os/file.h"

namespace tims::os {

// Within that time; -1 never is.
inline bool is_readable(int fd, Duration within = {}) {
  const Time deadline = deadline_after(within);
  pollfd ready{fd, POLLIN, 0};
  for (;;) {
    const timespec rest = to_timespec(Time(std::max(deadline - now(), Duration::zero())));
    const int n = ::ppoll(&ready, 1, &rest, nullptr);
    if (n >= 0 || errno != EINTR) return n > 0;
  }
}

// Readable when one of them is. -1 and plain files, for which nobody can wait, are left out.
inline Result<File> any_of(std::span<const int> fds) {
  File any(::epoll_create1(EPOLL_CLOEXEC));
  if (!any) return system_error("epoll");
  for (const int fd : fds) {
    epoll_event readable{.events = EPOLLIN, .data = {}};
    if (fd < 0 || ::epoll_ctl(any.get(), EPOLL_CTL_ADD, fd, &readable) == 0) continue;
    if (errno != EPERM) return system_error("epoll");
  }
  return any;
}

}  // namespace tims::os

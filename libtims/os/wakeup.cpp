#include "os/wakeup.h"

#include <algorithm>
#include <array>

#include <linux/futex.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>

namespace tims::os {

void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, Time deadline) {
  timespec until{};
  timespec* limit = nullptr;
  if (deadline != kNever) {
    until = to_timespec(deadline);
    limit = &until;
  }
  // BITSET: the deadline is absolute, on the monotonic clock.
  ::syscall(SYS_futex, &word, FUTEX_WAIT_BITSET, expected, limit, nullptr, FUTEX_BITSET_MATCH_ANY);
}

void futex_clear_and_wake(const std::atomic<std::uint32_t>& word) {
  // The comparison is never true: no second sleeper is woken.
  const std::uint32_t operation = FUTEX_OP(FUTEX_OP_ANDN, 1, FUTEX_OP_CMP_LT, 0);
  const std::uintptr_t second_wakes = 0;
  ::syscall(SYS_futex, &word, FUTEX_WAKE_OP, 1, second_wakes, &word, operation);
}

Result<File> make_event_fd() {
  File file(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!file) return system_error("eventfd");
  return file;
}

void signal_event_fd(int fd) { ::eventfd_write(fd, 1); }

void drain_event_fd(int fd) {
  std::uint64_t value = 0;
  const iovec whole{&value, sizeof value};
  (void)::preadv2(fd, &whole, 1, -1, RWF_NOWAIT);
}

Result<WakePair> make_wake_pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
    return system_error("socketpair");
  return WakePair{File(ends[0]), File(ends[1])};
}

bool is_waker(int fd) {
  const auto option = [fd](int name) {
    int value = -1;
    socklen_t size = sizeof value;
    return ::getsockopt(fd, SOL_SOCKET, name, &value, &size) == 0 ? value : -1;
  };
  return option(SO_DOMAIN) == AF_UNIX && option(SO_TYPE) == SOCK_DGRAM;
}

void wake(int waker) { ::send(waker, nullptr, 0, MSG_DONTWAIT | MSG_NOSIGNAL); }

void drain_wakes(int woken) {
  // more than a socket queues by default (net.unix.max_dgram_qlen)
  constexpr unsigned kAtOnce = 16;
  std::array<mmsghdr, kAtOnce> wakes{};
  while (::recvmmsg(woken, wakes.data(), kAtOnce, MSG_DONTWAIT, nullptr) == kAtOnce) {
  }
}

bool poll_until(std::span<pollfd> waits, Time deadline) {
  for (;;) {
    const timespec rest = to_timespec(Time(std::max(deadline - now(), Duration::zero())));
    const int n =
        ::ppoll(waits.data(), waits.size(), deadline == kNever ? nullptr : &rest, nullptr);
    if (n >= 0 || errno != EINTR) return n > 0;
  }
}

bool is_ready(int fd, short events, Time deadline) {
  pollfd wait{fd, events, 0};
  return poll_until({&wait, 1}, deadline);
}

bool is_readable(int fd, Duration within) { return is_ready(fd, POLLIN, deadline_after(within)); }

Result<File> any_of(std::span<const int> fds) {
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

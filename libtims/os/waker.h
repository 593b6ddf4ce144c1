// A wake-up between programs that do not trust each other: a pair of datagram sockets. The owner
// keeps one end, for its event loop, and gives the other away; what is sent there wakes it.
//
// An eventfd would not do: its flags belong to everybody who has it, so that its owner could fill
// it, clear O_NONBLOCK, and have whoever wants to wake it wait.
#pragma once

#include <array>

#include <sys/socket.h>

#include "os/file.h"

namespace tims::os {

struct WakePair {
  File woken;  // readable until drain_wakes()
  File waker;
};
inline Result<WakePair> make_wake_pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
    return system_error("socketpair");
  return WakePair{File(ends[0]), File(ends[1])};
}

// Of a descriptor that somebody gave us. Sockets of other families can be locked for as long as
// another program likes, which MSG_DONTWAIT waits for all the same.
inline bool is_waker(int fd) {
  const auto option = [fd](int name) {
    int value = -1;
    socklen_t size = sizeof value;
    return ::getsockopt(fd, SOL_SOCKET, name, &value, &size) == 0 ? value : -1;
  };
  return option(SO_DOMAIN) == AF_UNIX && option(SO_TYPE) == SOCK_DGRAM;
}

// Never waits, whatever has been done to the sockets. When no more goes in, there is enough to wake
// the owner. Empty: it means nothing to whoever else it may reach.
inline void wake(int waker) { ::send(waker, nullptr, 0, MSG_DONTWAIT | MSG_NOSIGNAL); }

inline void drain_wakes(int woken) {
  constexpr unsigned kAtOnce = 16;  // more than wait by default (net.unix.max_dgram_qlen)
  std::array<mmsghdr, kAtOnce> wakes{};
  while (::recvmmsg(woken, wakes.data(), kAtOnce, MSG_DONTWAIT, nullptr) == kAtOnce) {
  }
}

}  // namespace tims::os

#include "components/devices/io/stamped.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include <linux/errqueue.h>
#include <linux/net_tstamp.h>

#include "os/clock.h"
#include "os/file.h"
#include "rack/devices/device_clock.h"

namespace rack::device {
namespace {

using tims::Duration;
using tims::Time;

Time monotonic(const timespec& stamp) {
  return stamped_at(std::chrono::seconds(stamp.tv_sec) + Duration(stamp.tv_nsec),
                    tims::os::wall_now().time_since_epoch(), tims::os::now());
}

}  // namespace

void ask_for_stamps(int socket) {
  const int on = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
  const int flags = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
  ::setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPING, &flags, sizeof flags);
}

tims::Result<Stamped> receive_stamped(int socket, std::span<std::byte> bytes, sockaddr* from,
                                      socklen_t& from_size) {
  alignas(cmsghdr) std::array<std::byte, 128> control{};
  iovec part{.iov_base = bytes.data(), .iov_len = bytes.size()};
  msghdr message{};
  message.msg_name = from;
  message.msg_namelen = from_size;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  ssize_t size = 0;
  do {
    size = ::recvmsg(socket, &message, MSG_DONTWAIT);
  } while (size < 0 && (errno == EINTR || errno == ECONNREFUSED));
  if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Stamped{};
  if (size < 0) return tims::os::system_error("receive");
  from_size = message.msg_namelen;

  Stamped stamped{
      .is_there = true, .size = static_cast<std::size_t>(size), .when = tims::os::now()};
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_TIMESTAMPING) {
      scm_timestamping stamps{};
      std::memcpy(&stamps, CMSG_DATA(c), sizeof stamps);
      if (stamps.ts[0].tv_sec != 0) stamped.when = monotonic(stamps.ts[0]);
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&stamped.dropped, CMSG_DATA(c), sizeof stamped.dropped);
    }
  }
  return stamped;
}

}  // namespace rack::device

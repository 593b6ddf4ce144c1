#include "router/io/http/tcp_progress.h"

// The C library's own <netinet/tcp.h> does not know this field, and cannot be included with it.
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace tims::io {

std::uint64_t bytes_acknowledged(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;
  return info.tcpi_bytes_acked;
}

}  // namespace tims::io

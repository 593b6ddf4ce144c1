#include "devices/io/can_restart.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include "os/file.h"

namespace rack::device {
namespace {

using tims::Result;
using tims::os::File;
using tims::os::system_error;

// A request with its attributes, one inside the other.
class Request {
 public:
  explicit Request(unsigned interface_index) {
    head_.nlmsg_len = NLMSG_LENGTH(sizeof(ifinfomsg));
    head_.nlmsg_type = RTM_NEWLINK;
    head_.nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK;
    ifinfomsg link{};
    link.ifi_family = AF_UNSPEC;
    link.ifi_index = static_cast<int>(interface_index);
    std::memcpy(bytes_.data() + NLMSG_HDRLEN, &link, sizeof link);
    size_ = head_.nlmsg_len;
  }

  std::size_t open(unsigned short type) { return add(type, {}); }
  void close(std::size_t begin) {
    const auto length = static_cast<unsigned short>(size_ - begin);
    std::memcpy(bytes_.data() + begin, &length, sizeof length);
  }
  std::size_t add(unsigned short type, std::string_view value) {
    const std::size_t begin = size_;
    rtattr attribute{};
    attribute.rta_type = type;
    attribute.rta_len = static_cast<unsigned short>(RTA_LENGTH(value.size()));
    std::memcpy(bytes_.data() + begin, &attribute, sizeof attribute);
    std::memcpy(bytes_.data() + begin + RTA_LENGTH(0), value.data(), value.size());
    size_ = begin + RTA_SPACE(value.size());
    return begin;
  }
  std::string_view bytes() {
    head_.nlmsg_len = static_cast<std::uint32_t>(size_);
    std::memcpy(bytes_.data(), &head_, sizeof head_);
    return {bytes_.data(), size_};
  }

 private:
  nlmsghdr head_{};
  std::array<char, 256> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace

Result<void> restart_can(unsigned interface_index) {
  const File socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  if (!socket) return system_error("netlink");
  Request request(interface_index);
  const std::size_t info = request.open(IFLA_LINKINFO);
  request.add(IFLA_INFO_KIND, "can");
  const std::size_t data = request.open(IFLA_INFO_DATA);
  const std::uint32_t yes = 1;
  request.add(IFLA_CAN_RESTART, {reinterpret_cast<const char*>(&yes), sizeof yes});
  request.close(data);
  request.close(info);
  const std::string_view bytes = request.bytes();
  if (::send(socket.get(), bytes.data(), bytes.size(), 0) < 0) return system_error("netlink");
  std::array<char, 512> answer{};
  const ssize_t size = ::recv(socket.get(), answer.data(), answer.size(), 0);
  nlmsghdr head{};
  nlmsgerr result{};
  if (size < static_cast<ssize_t>(NLMSG_HDRLEN + sizeof result)) return system_error("netlink");
  std::memcpy(&head, answer.data(), sizeof head);
  std::memcpy(&result, answer.data() + NLMSG_HDRLEN, sizeof result);
  if (head.nlmsg_type != NLMSG_ERROR || result.error == 0) return {};
  errno = -result.error;
  return system_error("restart");
}

}  // namespace rack::device

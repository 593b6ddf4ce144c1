#include "components/devices/io/can_link.h"

#include <algorithm>
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

// A netlink request with nested attributes.
class Request {
 public:
  Request(unsigned short type, unsigned short flags, unsigned interface_index) {
    head_.nlmsg_len = NLMSG_LENGTH(sizeof(ifinfomsg));
    head_.nlmsg_type = type;
    head_.nlmsg_flags = NLM_F_REQUEST | flags;
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

template <typename Value>
std::optional<Value> value_of(std::span<const std::byte> bytes) {
  Value value{};
  if (bytes.size() < sizeof value) return std::nullopt;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

// Finds the attribute of a type in a sequence of attributes; empty if there is none.
std::span<const std::byte> attribute(std::span<const std::byte> all, unsigned short type) {
  while (const auto head = value_of<rtattr>(all)) {
    if (head->rta_len < RTA_LENGTH(0) || head->rta_len > all.size()) break;
    if ((head->rta_type & NLA_TYPE_MASK) == type)
      return all.subspan(RTA_LENGTH(0), head->rta_len - RTA_LENGTH(0));
    all = all.subspan(std::min<std::size_t>(RTA_ALIGN(head->rta_len), all.size()));
  }
  return {};
}

// Sends a request and stores the answer in `answer`.
Result<std::span<const std::byte>> ask(std::string_view bytes, std::span<std::byte> answer) {
  const File socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
  if (!socket || ::send(socket.get(), bytes.data(), bytes.size(), 0) < 0)
    return system_error("netlink");
  const ssize_t size = ::recv(socket.get(), answer.data(), answer.size(), 0);
  if (size < 0) return system_error("netlink");
  const std::span<const std::byte> got = answer.first(static_cast<std::size_t>(size));
  const auto head = value_of<nlmsghdr>(got);
  if (!head || head->nlmsg_type != NLMSG_ERROR) return got;
  const auto result = value_of<nlmsgerr>(got.subspan(NLMSG_HDRLEN));
  errno = result ? -result->error : EPROTO;
  if (errno != 0) return system_error("the kernel");
  return got;
}

}  // namespace

CanLink parse_can_link(std::span<const std::byte> message) {
  constexpr std::array<const char*, 6> kStates = {"error-active", "error-warning", "error-passive",
                                                  "bus-off",      "stopped",       "sleeping"};
  CanLink link;
  constexpr std::size_t kHead = NLMSG_HDRLEN + NLMSG_ALIGN(sizeof(ifinfomsg));
  const auto head = value_of<nlmsghdr>(message);
  if (!head || head->nlmsg_type != RTM_NEWLINK || message.size() < kHead) return link;
  const auto info = attribute(message.subspan(kHead), IFLA_LINKINFO);
  const auto kind = attribute(info, IFLA_INFO_KIND);
  const std::string_view name(reinterpret_cast<const char*>(kind.data()), kind.size());
  link.is_hardware = name.substr(0, name.find('\0')) == "can";
  const auto data = attribute(info, IFLA_INFO_DATA);
  const auto timing = value_of<can_bittiming>(attribute(data, IFLA_CAN_BITTIMING));
  if (timing && timing->bitrate != 0) link.bit_rate = timing->bitrate;
  const auto state = value_of<std::uint32_t>(attribute(data, IFLA_CAN_STATE));
  if (state && *state < kStates.size()) link.state = kStates[*state];
  return link;
}

Result<CanLink> can_link(unsigned interface_index) {
  std::array<std::byte, 16384> answer{};
  const auto got = ask(Request(RTM_GETLINK, 0, interface_index).bytes(), answer);
  if (!got) return got.error();
  return parse_can_link(*got);
}

Result<void> restart_can(unsigned interface_index) {
  Request request(RTM_NEWLINK, NLM_F_ACK, interface_index);
  const std::size_t info = request.open(IFLA_LINKINFO);
  request.add(IFLA_INFO_KIND, "can");
  const std::size_t data = request.open(IFLA_INFO_DATA);
  const std::uint32_t yes = 1;
  request.add(IFLA_CAN_RESTART, {reinterpret_cast<const char*>(&yes), sizeof yes});
  request.close(data);
  request.close(info);
  std::array<std::byte, 512> answer{};
  if (const auto done = ask(request.bytes(), answer); !done) return done.error();
  return {};
}

}  // namespace rack::device

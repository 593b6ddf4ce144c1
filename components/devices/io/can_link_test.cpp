#include "components/devices/io/can_link.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

namespace rack::device {
namespace can_link_test {

void put(std::vector<std::byte>& to, const auto& value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  to.insert(to.end(), bytes.begin(), bytes.end());
}
std::vector<std::byte> attribute_of(unsigned short type, std::span<const std::byte> value) {
  std::vector<std::byte> all;
  put(all,
      rtattr{.rta_len = static_cast<unsigned short>(RTA_LENGTH(value.size())), .rta_type = type});
  all.insert(all.end(), value.begin(), value.end());
  all.resize(RTA_ALIGN(all.size()));
  return all;
}
std::vector<std::byte> joined(std::vector<std::byte> one, const std::vector<std::byte>& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

// Answer of kernel 6.1 for a controller; truncated attributes are ignored.
TEST(CanLinkTest, ItsBitRateAndStateAreRead) {
  std::vector<std::byte> timing;
  can_bittiming rate{};
  rate.bitrate = 500000;
  put(timing, rate);
  std::vector<std::byte> state;
  put(state, std::uint32_t{3});
  const auto data =
      joined(attribute_of(IFLA_CAN_CTRLMODE, std::array<std::byte, 8>{}),
             joined(attribute_of(IFLA_CAN_BITTIMING, timing), attribute_of(IFLA_CAN_STATE, state)));
  const auto info = joined(attribute_of(IFLA_INFO_KIND, std::as_bytes(std::span("can"))),
                           attribute_of(IFLA_INFO_DATA | NLA_F_NESTED, data));
  std::vector<std::byte> message;
  nlmsghdr head{};
  head.nlmsg_type = RTM_NEWLINK;
  put(message, head);
  put(message, ifinfomsg{});
  message = joined(message, joined(attribute_of(IFLA_IFNAME, std::as_bytes(std::span("can0"))),
                                   attribute_of(IFLA_LINKINFO, info)));
  const CanLink link = parse_can_link(message);
  EXPECT_TRUE(link.is_hardware);
  EXPECT_EQ(link.bit_rate, 500000U);
  EXPECT_EQ(link.state, "bus-off");
  for (std::size_t size = 0; size < message.size(); ++size) {
    const std::vector<std::byte> cut(message.begin(),
                                     message.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(parse_can_link(cut).state, "") << size;
  }
}

}  // namespace can_link_test
}  // namespace rack::device

#include "router/link/control.h"

#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

TEST(Control, AnnouncementsReadBackInGroups) {
  ControlMessage message(control::kAdd);
  const core::Origin a{Address(1), 2, 3};
  const core::Origin b{Address(4), 5, 6};
  message.put(Address(100), a);
  message.put(Address(101), a);
  message.put(Address(102), b);
  const auto body = message.finish().subspan(kHeaderSize);
  std::vector<std::pair<std::uint32_t, std::uint8_t>> read;
  const auto visit = [&](Address address, const core::Origin& origin) {
    read.emplace_back(address.raw(), origin.hops);
  };
  EXPECT_TRUE(read_announcements(body, visit));
  EXPECT_EQ(read,
            (std::vector<std::pair<std::uint32_t, std::uint8_t>>{{100, 3}, {101, 3}, {102, 6}}));
  EXPECT_FALSE(read_announcements(body.first(body.size() - 1), visit));
}

}  // namespace
}  // namespace tims::link

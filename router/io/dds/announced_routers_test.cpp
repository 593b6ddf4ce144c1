#include "router/io/dds/announced_routers.h"

#include <gtest/gtest.h>

namespace tims::io::announced_routers_test {

link::NetAddress number(std::size_t n) {
  return link::NetAddress::dds({static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}

TEST(AnnouncedRouters, AreBounded) {
  AnnouncedRouters known;
  for (std::size_t i = 0; i < AnnouncedRouters::kMax - 1; ++i) ASSERT_TRUE(known.add(number(i)));
  EXPECT_TRUE(known.add(number(AnnouncedRouters::kMax - 1))) << "the last one";
  EXPECT_FALSE(known.add(number(AnnouncedRouters::kMax)));
  EXPECT_TRUE(known.add(number(7))) << "news of a known one";
  known.remove(number(7));
  EXPECT_TRUE(known.add(number(AnnouncedRouters::kMax))) << "in its place";
  EXPECT_FALSE(known.add(number(7)));
  EXPECT_EQ(known.take().size(), AnnouncedRouters::kMax);
  EXPECT_TRUE(known.take().empty());
  EXPECT_TRUE(known.add(number(7)));
}

}  // namespace tims::io::announced_routers_test

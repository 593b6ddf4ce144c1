#include "router/config/networks.h"

#include <gtest/gtest.h>

namespace tims::config::networks_test {

bool contains(std::string_view list, std::string_view endpoint) {
  return Networks::parse(list).value().contains(endpoint);
}

TEST(Networks, LoopbackIsBothFamilies) {
  EXPECT_TRUE(contains("loopback", "127.0.0.1:4000"));
  EXPECT_TRUE(contains("loopback", "127.255.0.9:4000"));
  EXPECT_TRUE(contains("loopback", "[::1]:4000"));
  EXPECT_TRUE(contains("loopback", "[::ffff:127.0.0.1]:4000"));
  EXPECT_FALSE(contains("loopback", "128.0.0.1:4000"));
  EXPECT_FALSE(contains("loopback", "[::2]:4000"));
  EXPECT_FALSE(contains("", "127.0.0.1:4000"));
  EXPECT_FALSE(contains("loopback", ""));
}

TEST(Networks, BitsAreCompared) {
  EXPECT_TRUE(contains("10.9.0.0/16, fd00::/8", "10.9.255.1:1"));
  EXPECT_FALSE(contains("10.9.0.0/16, fd00::/8", "10.10.0.1:1"));
  EXPECT_TRUE(contains("10.9.0.0/16, fd00::/8", "[fdff::1]:1"));
  EXPECT_TRUE(contains("10.8.0.0/15", "10.9.0.1:1"));
  EXPECT_FALSE(contains("10.8.0.0/15", "10.10.0.1:1"));
  EXPECT_TRUE(contains("10.9.1.7", "10.9.1.7:1"));
  EXPECT_FALSE(contains("10.9.1.7", "10.9.1.8:1"));
  EXPECT_TRUE(contains("0.0.0.0/0", "8.8.8.8:1"));
  EXPECT_FALSE(contains("0.0.0.0/0", "[fd00::1]:1"));
  EXPECT_TRUE(contains("::/0", "8.8.8.8:1"));
}

TEST(Networks, MistakesAreNamed) {
  for (const char* wrong : {"10.9.0.0/33", "fd00::/129", "robot7", "10.9.0/16", "10.9.0.0/", "/8"})
    EXPECT_FALSE(Networks::parse(wrong)) << wrong;
}

}  // namespace tims::config::networks_test

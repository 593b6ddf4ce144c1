#include "base/ip_network.h"

#include <string>

#include <gtest/gtest.h>

namespace tims::base::ip_network_test {

bool contains(std::string_view wide, std::string_view narrow) {
  return IpNetwork::parse(wide).value().contains(IpNetwork::parse(narrow).value());
}

TEST(IpNetwork, BitsAreCompared) {
  EXPECT_TRUE(contains("10.9.0.0/16", "10.9.255.1"));
  EXPECT_FALSE(contains("10.9.0.0/16", "10.8.255.255"));
  EXPECT_TRUE(contains("10.8.0.0/15", "10.9.0.1"));
  EXPECT_FALSE(contains("10.8.0.0/15", "10.10.0.1"));
  EXPECT_TRUE(contains("10.9.1.7", "10.9.1.7"));
  EXPECT_FALSE(contains("10.9.1.7", "10.9.1.6"));
  EXPECT_TRUE(contains("10.9.1.7/32", "10.9.1.7"));
  EXPECT_TRUE(contains("fe80::/10", "febf::1"));
  EXPECT_FALSE(contains("fe80::/10", "fec0::1"));
  EXPECT_TRUE(contains("::1/128", "::1"));
}

TEST(IpNetwork, MappedAddressesAreIpv4) {
  EXPECT_TRUE(contains("10.9.1.7", "::ffff:10.9.1.7"));
  EXPECT_TRUE(contains("0.0.0.0/0", "1.2.3.4"));
  EXPECT_FALSE(contains("0.0.0.0/0", "fe80::1"));
  EXPECT_TRUE(contains("::/0", "8.8.8.8"));
}

TEST(IpNetwork, ContainsWholeNetworksOnly) {
  EXPECT_TRUE(contains("10.0.0.0/8", "10.9.0.0/16"));
  EXPECT_FALSE(contains("10.9.0.0/16", "10.0.0.0/8"));
  EXPECT_TRUE(contains("10.9.0.0/16", "10.9.0.0/16"));
}

TEST(IpNetwork, OtherTextsAreRefused) {
  for (const char* wrong :
       {"", "/8", "10.9.0.0/33", "fd00::/129", "10.9.0.0/", "10.9.0.0/-1", "10.9.0.0/1x", "10.9/16",
        "300.1.1.1", "1.2.3.4.5", "1:2", "::1::2", "12345::", "robot7", "fe80::1%eth0"})
    EXPECT_FALSE(IpNetwork::parse(wrong)) << wrong;
  EXPECT_FALSE(IpNetwork::parse(std::string("10.9.1.7\0/8", 11))) << "a zero byte";
}

}  // namespace tims::base::ip_network_test

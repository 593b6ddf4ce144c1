#include <gtest/gtest.h>

#include "router/config/config.h"

namespace tims::config {
namespace {

std::string round_trip(std::string_view text) {
  const auto endpoint = Endpoint::parse(text);
  return endpoint ? endpoint->to_string() : "refused";
}

TEST(Endpoint, ReadsAddressesOfBothFamilies) {
  EXPECT_EQ(round_trip("127.0.0.1:2000"), "127.0.0.1:2000");
  EXPECT_EQ(round_trip("0.0.0.0:65535"), "0.0.0.0:65535");
  EXPECT_EQ(round_trip("[::1]:2000"), "[::1]:2000");
  EXPECT_EQ(round_trip("[fe80::1]:0"), "[fe80::1]:0");
}

TEST(Endpoint, LocalhostIsTheLoopbackAddress) {
  EXPECT_EQ(round_trip("localhost:2000"), "127.0.0.1:2000");
}

TEST(Endpoint, RefusesWhatCannotBeListenedAt) {
  for (const char* text :
       {"", ":", "2000", ":2000", "*:2000", "robot1:2000", "127.0.0.1",
        "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:2000 ", "127.0.0.1:2k",
        "::1:2000", "[::1]", "[::1:2000", "[]:2000", "[127.0.0.1]:2000", "256.0.0.1:2000"})
    EXPECT_FALSE(Endpoint::parse(text)) << text;
}

TEST(Endpoint, KnowsLoopback) {
  EXPECT_TRUE(Endpoint::parse("127.0.0.1:1")->loopback());
  EXPECT_TRUE(Endpoint::parse("127.255.3.4:1")->loopback());
  EXPECT_TRUE(Endpoint::parse("[::1]:1")->loopback());
  EXPECT_FALSE(Endpoint::parse("0.0.0.0:1")->loopback());
  EXPECT_FALSE(Endpoint::parse("128.0.0.1:1")->loopback());
  EXPECT_FALSE(Endpoint::parse("[::]:1")->loopback());
  EXPECT_FALSE(Endpoint::parse("[::2]:1")->loopback());
}

}  // namespace
}  // namespace tims::config

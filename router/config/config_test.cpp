#include "router/config/config.h"

#include <gtest/gtest.h>

namespace tims::config {
namespace config_test {

template <typename T>
std::string read_back(std::string_view text) {
  const auto value = T::parse(text);
  return value ? value->to_string() : "refused";
}

TEST(Endpoint, ReadsAddressesOfBothFamilies) {
  EXPECT_EQ(read_back<Endpoint>("127.0.0.1:2000"), "127.0.0.1:2000");
  EXPECT_EQ(read_back<Endpoint>("0.0.0.0:65535"), "0.0.0.0:65535");
  EXPECT_EQ(read_back<Endpoint>("[::1]:2000"), "[::1]:2000");
  EXPECT_EQ(read_back<Endpoint>("[fe80::1]:0"), "[fe80::1]:0");
}

TEST(Endpoint, LocalhostIsTheLoopbackAddress) {
  EXPECT_EQ(read_back<Endpoint>("localhost:2000"), "127.0.0.1:2000");
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

TEST(Destination, IsAnAddressOrAName) {
  EXPECT_EQ(read_back<Destination>("10.9.1.1:2011"), "10.9.1.1:2011");
  EXPECT_EQ(read_back<Destination>("[fd00::1]:2011"), "[fd00::1]:2011");
  EXPECT_EQ(read_back<Destination>("[fe80::1%enP3s0.7]:2011"), "[fe80::1%enP3s0.7]:2011");
  EXPECT_EQ(read_back<Destination>("robot1:2011"), "robot1:2011");
  EXPECT_EQ(read_back<Destination>("Robot-1.fleet_2.Example.org:1"),
            "robot-1.fleet_2.example.org:1");
  EXPECT_EQ(read_back<Destination>("localhost:2011"), "127.0.0.1:2011");
}

TEST(Destination, WithoutPortItIsTheDefaultPort) {
  EXPECT_EQ(read_back<Destination>("10.9.1.1"), "10.9.1.1:2010");
  EXPECT_EQ(read_back<Destination>("robot1"), "robot1:2010");
  EXPECT_EQ(read_back<Destination>("[::1]"), "[::1]:2010");
}

TEST(Destination, RefusesWhatCannotBeReached) {
  for (const char* text : {"",
                           ":",
                           ":2010",
                           "robot1:",
                           "robot1:0",
                           "robot1:65536",
                           "robot1:x",
                           "robot1:1:2",
                           "::1",
                           "fd00::1:2010",
                           "[::1",
                           "[::1]2010",
                           "[]:2010",
                           "[robot1]:2010",
                           "[127.0.0.1]:2010",
                           "[fe80::1%]:1",
                           "[fe80::1%a b]:1",
                           "256.0.0.1:2010",
                           "10.9.1:2010",
                           "2010",
                           "*:2010",
                           "a b:1",
                           "-a:1",
                           "a-:1",
                           "a..b:1",
                           ".a:1",
                           "a.:1",
                           "http://robot1:2010",
                           "robot1/x"})
    EXPECT_FALSE(Destination::parse(text)) << text;
  EXPECT_TRUE(Destination::parse(std::string(253, 'a')));
  EXPECT_FALSE(Destination::parse(std::string(254, 'a')));
}

TEST(Destination, KnowsLoopbackWithoutLookingNamesUp) {
  EXPECT_TRUE(Destination::parse("127.0.0.1:1")->loopback());
  EXPECT_TRUE(Destination::parse("[::1]:1")->loopback());
  EXPECT_TRUE(Destination::parse("localhost:1")->loopback());
  EXPECT_FALSE(Destination::parse("10.9.1.1:1")->loopback());
  EXPECT_FALSE(Destination::parse("robot1:1")->loopback());
}

TEST(Link, IsNamedByWhereItGoesOrWhomItAccepts) {
  const auto name = [](LinkKind kind, const std::string& host, std::optional<std::uint8_t> system) {
    Link link;
    link.kind = kind;
    link.host = host;
    link.port = 2010;
    link.system = system;
    return link.to_string();
  };
  EXPECT_EQ(name(LinkKind::kSuper, "10.9.1.1", {}), "10.9.1.1:2010");
  EXPECT_EQ(name(LinkKind::kSub, "", 1), "sub of system 1");
  EXPECT_EQ(name(LinkKind::kPeer, "", {}), "peer of *");
}

}  // namespace config_test

}  // namespace tims::config

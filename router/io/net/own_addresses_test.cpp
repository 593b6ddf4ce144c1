#include "router/io/net/own_addresses.h"

#include <gtest/gtest.h>

#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/own_network.h"

namespace tims::io {
namespace {

using link::NetAddress;

void run(const std::string& commands) {
  auto child = test::ChildProcess::start({"sh", "-ec", commands});
  ASSERT_TRUE(child.ok() && child->wait().ok()) << commands;
}

TEST(OwnAddresses, OfASocketWithAnAddressItIsThat) {
  const NetAddress bound = NetAddress::v4(127, 0, 0, 1, 2010);
  EXPECT_EQ(own_addresses(bound), std::vector{bound});
}

TEST(OwnAddresses, OfOneForAllTheyAreThoseWithACarrier) {
  const auto network = test::OwnNetwork::enter();
  if (!network) GTEST_SKIP() << network.error().message();
  const NetAddress all = NetAddress::v4(0, 0, 0, 0, 2010);
  EXPECT_EQ(own_addresses(all), std::vector{NetAddress::v4(127, 0, 0, 1, 2010)});
  run("ip link add left type veth peer name right\n"
      "ip address add 10.79.0.1/24 dev left\n"
      "ip link set left up");
  EXPECT_EQ(own_addresses(all), std::vector{NetAddress::v4(127, 0, 0, 1, 2010)});
  run("ip link set right up");
  EXPECT_TRUE(test::eventually(
      [&] { return own_addresses(all) == std::vector{NetAddress::v4(10, 79, 0, 1, 2010)}; },
      "the cable's address"));
}

}  // namespace
}  // namespace tims::io

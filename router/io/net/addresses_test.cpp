#include "router/io/net/addresses.h"

#include <optional>

#include <gtest/gtest.h>

#include "os/clock.h"
#include "router/io/loop.h"
#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/own_network.h"
#include "tests/support/patience.h"

namespace tims::io {
namespace addresses_test {

using std::chrono::milliseconds;

constexpr Time kStart{std::chrono::seconds(100)};

TEST(Debounce, NothingIsDueWithoutAChange) { EXPECT_EQ(Debounce().due(), kNever); }

TEST(Debounce, IsDueWhenChangesHaveEnded) {
  Debounce debounce;
  debounce.on_change(kStart);
  EXPECT_EQ(debounce.due(), kStart + milliseconds(50));
  debounce.on_change(kStart + milliseconds(30));
  EXPECT_EQ(debounce.due(), kStart + milliseconds(80));
}

TEST(Debounce, ChangesWithoutEndDoNotPutItOffForEver) {
  Debounce debounce;
  for (int ms = 0; ms < 300; ms += 20) debounce.on_change(kStart + milliseconds(ms));
  EXPECT_EQ(debounce.due(), kStart + milliseconds(300));
}

TEST(Debounce, BeginsAnewAfterReset) {
  Debounce debounce;
  debounce.on_change(kStart);
  debounce.reset();
  EXPECT_EQ(debounce.due(), kNever);
  debounce.on_change(kStart + milliseconds(500));
  EXPECT_EQ(debounce.due(), kStart + milliseconds(550));
}

class Interfaces : public testing::Test {
 protected:
  void SetUp() override {
    auto entered = test::OwnNetwork::enter();
    if (!entered) GTEST_SKIP() << entered.error().message();
    network_.emplace(std::move(entered).value());
    const auto started = watch_.start();
    ASSERT_TRUE(started) << started.error().message();
  }

  // As a person would: "addr add ...".
  static void ip(std::vector<std::string> command) {
    command.insert(command.begin(), "ip");
    auto process = test::ChildProcess::start(std::move(command));
    ASSERT_TRUE(process) << process.error().message();
    const auto status = process->wait();
    ASSERT_TRUE(status && status->success()) << process->output();
  }

  void run_until(int changes) {
    const Time limit = os::now() + test::kPatience;
    while (changes_ < changes && os::now() < limit) loop_.run_once(limit);
    loop_.run_once(Time());
    EXPECT_EQ(changes_, changes);
  }

  std::optional<test::OwnNetwork> network_{};
  Loop loop_{};
  int changes_ = 0;
  InterfaceWatch watch_{loop_, [this] { ++changes_; }};
};

TEST_F(Interfaces, AnAddressComesAndGoes) {
  ip({"addr", "add", "10.9.1.1/24", "dev", "lo"});
  run_until(1);
  ip({"addr", "del", "10.9.1.1/24", "dev", "lo"});
  run_until(2);
}

TEST_F(Interfaces, ChangesCloseTogetherAreOne) {
  ip({"link", "set", "lo", "down"});
  ip({"link", "set", "lo", "up"});
  ip({"addr", "add", "10.9.1.1/24", "dev", "lo"});
  ip({"route", "add", "10.10.0.0/16", "dev", "lo"});
  run_until(1);
  ip({"route", "del", "10.10.0.0/16", "dev", "lo"});
  run_until(2);
}

TEST_F(Interfaces, MoreChangesThanTheSocketHoldsAreOne) {
  for (int i = 0; i < 2000; ++i) ASSERT_TRUE(test::OwnNetwork::set_loopback_mtu(1500 + i));
  run_until(1);
  ASSERT_TRUE(test::OwnNetwork::set_loopback_mtu(9000));
  run_until(2);
}

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

}  // namespace addresses_test

}  // namespace tims::io

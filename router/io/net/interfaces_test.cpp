#include "router/io/net/interfaces.h"

#include <optional>

#include <gtest/gtest.h>

#include "os/clock.h"
#include "router/io/loop.h"
#include "tests/support/child_process.h"
#include "tests/support/own_network.h"
#include "tests/support/patience.h"

namespace tims::io {
namespace {

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

}  // namespace
}  // namespace tims::io

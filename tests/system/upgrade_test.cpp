// Routers that are restarted as by systemd, between two hosts: their links go on.
#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/support/fleet_keys.h"
#include "tests/support/kept_pair.h"
#include "tests/system/two_hosts_fixture.h"

namespace tims::test {
namespace upgrade_test {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// Messages that arrive after a restart, before the next one.
constexpr std::uint64_t kMore = 100;

class UpgradeTest : public OnTwoNetworks {
 protected:
  void TearDown() override {
    if (HasFailure() && pair_) std::cerr << pair_->output();
    pair_.reset();
  }
  void start(const KeptPair::Settings& settings = {}) {
    pair_ = std::make_unique<KeptPair>(*networks_, settings);
    expect(pair_->start());
  }
  static void expect(const Result<void>& done) { ASSERT_TRUE(done.ok()) << done.error().message(); }
  [[nodiscard]] std::array<KeptRouter*, 2> routers() { return {&pair_->base(), &pair_->robot()}; }
  void expect_all() {
    pair_->end(kPatience);
    for (const auto& traffic : pair_->traffic()) {
      EXPECT_EQ(traffic->arrived(), traffic->sent());
      EXPECT_EQ(traffic->wrong(), 0U);
    }
  }
  void expect_restarts_unnoticed(int restarts) {
    for (int i = 0; i < restarts; ++i) {
      for (KeptRouter* router : routers()) {
        expect(pair_->restart(*router));
        expect(pair_->wait_for_more(kMore));
        EXPECT_THAT(router->process().output(), HasSubstr("go on from the former router: 1"));
      }
    }
    expect_all();
    for (KeptRouter* router : routers())
      EXPECT_THAT(router->process().output(), Not(HasSubstr("is down")));
  }
  // Nothing is waited for in between: not even that programs are back, or that a link has its keys.
  void expect_nothing_lost_in_a_storm() {
    KeptRouter* base = &pair_->base();
    KeptRouter* robot = &pair_->robot();
    for (KeptRouter* router : {base, base, robot, robot, base, robot, base, base, base, robot})
      expect(pair_->restart(*router));
    expect(pair_->wait_for_more(kMore));
    expect_all();
    for (KeptRouter* router : {base, robot})
      EXPECT_THAT(router->process().output(), HasSubstr("go on from the former router: 1"));
  }

  std::unique_ptr<KeptPair> pair_;
};

TEST_F(UpgradeTest, LosesNothingAndIsHardlyNoticed) {
  start();
  expect_restarts_unnoticed(5);
}

TEST_F(UpgradeTest, ASealedLinkGoesOnWithNewKeys) {
  FleetKeys keys;
  start({.keys_base = keys.base(),
         .keys_robot = keys.join("robot", security::MemberRole::kSystem, 1, 1)});
  expect_restarts_unnoticed(3);
}

TEST_F(UpgradeTest, LosesNothingHoweverSoonTheNextRestartComes) {
  start();
  expect_nothing_lost_in_a_storm();
}

TEST_F(UpgradeTest, ASealedLinkLosesNothingHoweverSoonTheNextRestartComes) {
  FleetKeys keys;
  start({.keys_base = keys.base(),
         .keys_robot = keys.join("robot", security::MemberRole::kSystem, 1, 1)});
  expect_nothing_lost_in_a_storm();
}

TEST_F(UpgradeTest, ALinkOverTcpLosesNothing) {
  start({.path = "tcp"});
  // A connection is made again a second after the last one at the earliest.
  expect(pair_->wait_for_more(1500));
  for (KeptRouter* router : routers()) {
    expect(pair_->restart(*router));
    expect(pair_->wait_for_more(kMore));
  }
  expect_all();
}

// Of the next version of this program, or of the one before.
TEST_F(UpgradeTest, AnotherLayoutIsAPlainRestart) {
  start();
  pair_->end(kPatience);
  expect(pair_->restart_with_other_layout(pair_->base()));
  EXPECT_THAT(pair_->base().process().output(), HasSubstr("it has layout 2, this program has 1"));
  EXPECT_THAT(pair_->base().keeper().names(), Not(Contains("links")));
  expect(pair_->begin_traffic());  // the link is up again
}

// Messages on their way are lost then, and the sessions begin anew.
TEST_F(UpgradeTest, AfterACrashTheLinksBeginAnew) {
  start();
  expect(pair_->restart(pair_->base(), SIGKILL));
  const NumberedTraffic& up = *pair_->traffic().front();
  const std::uint64_t before = up.arrived();
  EXPECT_TRUE(eventually([&] { return up.arrived() > before; }, "the link is up again"));
  EXPECT_THAT(pair_->base().process().output(), Not(HasSubstr("go on from the former router")));
}

}  // namespace upgrade_test
}  // namespace tims::test

// Routers that are restarted as by systemd, between two hosts: their links go on.
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "os/shared_memory.h"
#include "router/link/handover.h"
#include "tests/support/descriptor_keeper.h"
#include "tests/support/eventually.h"
#include "tests/support/numbered_traffic.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/two_networks.h"
#include "tests/system/fleet_keys.h"

namespace tims::test {
namespace upgrade_test {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr Address kLadar(0x01140000);
constexpr Address kGui(0x00020000);
constexpr Address kPilot(0x01150000);
constexpr Address kOther(0x00030000);
// Of the sentence "at most 300 ms". An instrumented router starts slowly.
constexpr Duration kSilenceMax = kSlowdown * 300ms;

class UpgradeTest : public testing::Test {
 protected:
  void SetUp() override {
    auto made = TwoNetworks::enter();
    if (!made) GTEST_SKIP() << made.error().message();
    networks_.emplace(std::move(*made));
  }
  void TearDown() override {
    if (HasFailure() && robot_)
      std::cerr << "base:\n"
                << base_->process().output() << "robot:\n"
                << robot_->process().output();
    up_.reset();
    down_.reset();
    robot_.reset();
    base_.reset();
  }
  // `keys_*`: settings; none: without keys.
  void start(const std::string& keys_base, const std::string& keys_robot,
             const std::string& path = "udp") {
    const auto with = [](std::vector<std::string> settings, const std::string& keys) {
      settings.push_back(keys.empty() ? "security.insecure=true" : keys);
      return settings;
    };
    const std::string paths = path == "udp" ? "" : ",paths=" + path;
    base_.emplace(base_folder_.path(),
                  with({"router.name=base", "router.role=top", "router.system=0", "router.id=1",
                        std::string("udp.listen=") + TwoNetworks::kLeft + ":2010",
                        "link=kind=sub,system=*" + paths},
                       keys_base));
    robot_.emplace(robot_folder_.path(),
                   with({"router.name=robot", "router.role=system", "router.system=1",
                         "router.id=1", std::string("udp.listen=") + TwoNetworks::kRight + ":2010",
                         std::string("link=kind=super,to=") + TwoNetworks::kLeft + ":2010" + paths},
                        keys_robot));
    const auto base_started = base_->start();
    ASSERT_TRUE(base_started.ok()) << base_started.error().message();
    const auto robot_started = networks_->on_the_right([&] { return robot_->start(); });
    ASSERT_TRUE(robot_started.ok()) << robot_started.error().message();
    begin(up_, {robot_->socket_path(), kLadar}, {base_->socket_path(), kGui});
    begin(down_, {base_->socket_path(), kOther}, {robot_->socket_path(), kPilot});
    ASSERT_TRUE(eventually([&] { return up_->arrived() > 0 && down_->arrived() > 0; }, "a link"));
  }
  static void begin(std::unique_ptr<NumberedTraffic>& traffic, const NumberedTraffic::End& from,
                    const NumberedTraffic::End& to) {
    auto begun = NumberedTraffic::begin(from, to, 1ms);
    ASSERT_TRUE(begun.ok()) << begun.error().message();
    traffic = std::move(*begun);
  }
  void restart(KeptRouter& router, int signal = SIGUSR2) {
    const auto act = [&] { return router.restart(signal); };
    const auto done = &router == &*robot_ ? networks_->on_the_right(act) : act();
    ASSERT_TRUE(done.ok()) << done.error().message();
  }
  void wait_for_more() {
    const std::uint64_t up = up_->arrived();
    const std::uint64_t down = down_->arrived();
    ASSERT_TRUE(eventually(
        [&] { return up_->arrived() > up + 100 && down_->arrived() > down + 100; }, "more"));
  }
  void expect_all() {
    for (NumberedTraffic* traffic : {&*up_, &*down_}) {
      traffic->end(kPatience);
      EXPECT_EQ(traffic->arrived(), traffic->sent());
      EXPECT_EQ(traffic->wrong(), 0U);
    }
  }
  void expect_restarts_unnoticed(int restarts) {
    (void)up_->take_silence();
    (void)down_->take_silence();
    for (int i = 0; i < restarts; ++i) {
      for (KeptRouter* router : {&*base_, &*robot_}) {
        restart(*router);
        wait_for_more();
        EXPECT_THAT(router->process().output(), HasSubstr("go on from the former router: 1"));
      }
    }
    expect_all();
    EXPECT_LE(up_->silence(), kSilenceMax);
    EXPECT_LE(down_->silence(), kSilenceMax);
    RecordProperty("silence_ms",
                   static_cast<int>(std::max(up_->silence(), down_->silence()) / 1ms));
  }

  TemporaryFolder base_folder_;
  TemporaryFolder robot_folder_;
  std::optional<TwoNetworks> networks_;
  std::optional<KeptRouter> base_;
  std::optional<KeptRouter> robot_;
  std::unique_ptr<NumberedTraffic> up_;
  std::unique_ptr<NumberedTraffic> down_;
};

TEST_F(UpgradeTest, LosesNothingAndIsHardlyNoticed) {
  start("", "");
  expect_restarts_unnoticed(5);
}

TEST_F(UpgradeTest, ASealedLinkGoesOnWithNewKeys) {
  FleetKeys keys;
  start(keys.base(), keys.join("robot", security::MemberRole::kSystem, 1, 1));
  expect_restarts_unnoticed(3);
}

TEST_F(UpgradeTest, ALinkOverTcpLosesNothing) {
  start("", "", "tcp");
  // A connection is made again a second after the last one at the earliest.
  ASSERT_TRUE(eventually([&] { return up_->arrived() > 1500; }, "the connection is older"));
  for (KeptRouter* router : {&*base_, &*robot_}) {
    restart(*router);
    wait_for_more();
  }
  expect_all();
}

// Of the next version of this program, or of the one before.
TEST_F(UpgradeTest, AnotherLayoutIsAPlainRestart) {
  start("", "");
  up_->end(kPatience);
  down_->end(kPatience);
  ASSERT_TRUE(base_->keeper().end(base_->process(), SIGUSR2).ok());
  os::File& left = base_->keeper().kept().at("links");
  auto bytes = os::read_memfd(left, link::Handover::kBytesMax);
  ASSERT_TRUE(bytes.ok());
  bytes->at(8) = static_cast<std::byte>(link::Handover::kVersion + 1);
  auto newer = os::make_memfd("links", *bytes);
  ASSERT_TRUE(newer.ok());
  // Inherited by what is started.
  left = os::File(::fcntl(newer->get(), F_DUPFD, 200));
  ASSERT_TRUE(base_->start().ok());
  EXPECT_THAT(base_->process().output(), HasSubstr("it has layout 2, this program has 1"));
  EXPECT_THAT(base_->keeper().names(), testing::Not(testing::Contains("links")));
  begin(up_, {robot_->socket_path(), Address(0x01160000)},
        {base_->socket_path(), Address(0x00040000)});
  ASSERT_TRUE(eventually([&] { return up_->arrived() > 10; }, "the link is up again"));
}

// Messages on their way are lost then, and the sessions begin anew.
TEST_F(UpgradeTest, AfterACrashTheLinksBeginAnew) {
  start("", "");
  restart(*base_, SIGKILL);
  const std::uint64_t before = up_->arrived();
  EXPECT_TRUE(eventually([&] { return up_->arrived() > before; }, "the link is up again"));
  EXPECT_THAT(base_->process().output(), testing::Not(HasSubstr("go on from the former router")));
}

}  // namespace upgrade_test
}  // namespace tims::test

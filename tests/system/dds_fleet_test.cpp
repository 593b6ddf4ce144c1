// Routers that discover each other by the name of their fleet, on one machine.
#include "tests/system/dds_fixture.h"

namespace tims::test {
namespace dds_fleet_test {

using testing::HasSubstr;
using testing::Not;

class DdsFleet : public testing::Test {
 protected:
  void SetUp() override {
    auto made = OwnNetwork::enter();
    if (!made) GTEST_SKIP() << made.error().message();
    network_.emplace(std::move(*made));
  }
  std::unique_ptr<Host> start(const std::string& name, const std::string& role, int system, int id,
                              const std::string& more = "sim.faults=false") {
    auto host = fleet_host(name, role, system, id, "udp+dds", more);
    host->listen_at("0.0.0.0:0");
    host->start();
    return host;
  }
  static std::size_t links_up(const Host& host) {
    const std::string text = host.timsctl({"link", "show", "--json"});
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(R"("state":"up")", at)) != std::string::npos; ++at)
      ++n;
    return n;
  }

  std::optional<OwnNetwork> network_;
};

TEST_F(DdsFleet, EachFindsItsSuperRouter) {
  const auto base = start("base", "top", 0, 1);
  const auto robot = start("robot", "system", 3, 1);
  const auto arm = start("arm", "subsystem", 3, 2);
  const auto stranger = start("arm4", "subsystem", 4, 2);
  EXPECT_TRUE(goes_by(*robot, "base", "udp"));
  EXPECT_TRUE(goes_by(*arm, "robot", "udp"));
  EXPECT_TRUE(eventually([&] { return base->knows(Address(0x03000200)); }, "arm is known above"));
  EXPECT_THAT(stranger->timsctl({"link", "show"}),
              HasSubstr("the fleet has no router that is a system router of system 4"));
  EXPECT_THAT(arm->timsctl({"fleet", "show"}), HasSubstr("robot"));
}

TEST_F(DdsFleet, AnotherFleetIsNotDiscovered) {
  const auto base = start("base", "top", 0, 1);
  const auto other = start("other", "top", 0, 1, "fleet.name=other" + std::to_string(::getpid()));
  const auto robot = start("robot", "system", 1, 1);
  EXPECT_TRUE(goes_by(*robot, "base", "udp"));
  EXPECT_THAT(base->timsctl({"fleet", "show", "--json"}), Not(HasSubstr("\"other\"")));
  EXPECT_THAT(robot->timsctl({"fleet", "show", "--json"}), Not(HasSubstr("\"other\"")));
  EXPECT_EQ(links_up(*other), 0U);
}

TEST_F(DdsFleet, TwoRoutersWithOneIdAreReportedOnBothEnds) {
  const auto base = start("base", "top", 0, 1);
  const auto robot = start("robot", "system", 1, 1);
  EXPECT_TRUE(goes_by(*robot, "base", "udp"));
  const auto twin = start("twin", "system", 1, 1);
  const auto names = [](const std::unique_ptr<Host>& host, std::string_view name) {
    return eventually([&] { return host->log().find(name) != std::string::npos; },
                      "the log names " + std::string(name));
  };
  EXPECT_TRUE(names(twin, "robot"));
  EXPECT_TRUE(names(robot, "twin"));
  EXPECT_TRUE(names(base, "twin"));
  EXPECT_TRUE(goes_by(*base, "robot", "udp"));
}

// Fewer with a sanitizer, because it increases the memory of each.
TEST_F(DdsFleet, FiftyOnOneMachine) {
  const int robots = kSlowdown > 1 ? 9 : 49;
  const auto base = start("base", "top", 0, 1);
  std::vector<std::unique_ptr<Host>> all;
  for (int system = 1; system <= robots; ++system)
    all.push_back(start("robot" + std::to_string(system), "system", system, 1));
  EXPECT_TRUE(eventually(
      [&]() -> std::string {
        const std::size_t up = links_up(*base);
        return up == static_cast<std::size_t>(robots) ? "" : std::to_string(up) + " links are up";
      },
      3 * kPatience));
}

TEST_F(DdsFleet, ConfiguredPeersReplaceMulticast) {
  const auto base = start("base", "top", 0, 1, "dds.multicast=false");
  auto robot = std::make_unique<Host>("robot", "system", 1, 1,
                                      std::vector<std::string>{"kind=super,to=auto"}, [] {
                                        auto settings = fleet_settings("dds.multicast=false");
                                        settings.emplace_back("dds.peers=127.0.0.1");
                                        return settings;
                                      }());
  robot->start();
  EXPECT_TRUE(goes_by(*robot, "base", "udp"));
}

TEST_F(DdsFleet, ADiscoveryServerThatIsRestarted) {
  const std::string server_at = "127.0.0.1:11811";
  const auto serve = [&] {
    auto child = ChildProcess::start({TIMSCTL_PROGRAM, "fleet", "server", server_at});
    EXPECT_TRUE(child.ok());
    EXPECT_TRUE(child->wait_for_line("Server is running").ok());
    return std::move(*child);
  };
  auto server = serve();
  const auto base = start("base", "top", 0, 1, "dds.server=" + server_at);
  const auto robot = start("robot1", "system", 1, 1, "dds.server=" + server_at);
  EXPECT_TRUE(goes_by(*robot, "base", "udp"));
  server.signal(SIGKILL);
  EXPECT_TRUE(server.wait().ok());
  const auto late = start("robot2", "system", 2, 1, "dds.server=" + server_at);
  server = serve();
  EXPECT_TRUE(goes_by(*late, "base", "udp"));
  EXPECT_TRUE(goes_by(*robot, "base", "udp"));
  // As a service manager stops it: all its processes exit.
  server.signal(SIGTERM);
  EXPECT_TRUE(server.wait_for_line("Server shut down").ok());
  const auto status = server.wait();
  ASSERT_TRUE(status.ok());
  EXPECT_TRUE(status->success());
}

}  // namespace dds_fleet_test
}  // namespace tims::test

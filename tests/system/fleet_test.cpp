// Fleets of `timsctl sim`: real namespaces, routers and lines. Needs root.
#include <csignal>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "tests/support/eventually.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace fleet_test {

namespace fs = std::filesystem;

constexpr const char* kFleet = R"toml(
[[robot]]
hosts = ["main", "arm"]
link = "cable"
[base]
components = ["tims-demo client --at Test(0/2):1 --to Test(1/0)"]
[host.arm]
components = ["tims-demo server --at Test(1/0)"]
)toml";

class FleetTest : public testing::Test {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    const Ran probe = run({"sim", "show", "--json"});
    ASSERT_EQ(probe.code, 0) << probe.err;
    std::ofstream(file_) << kFleet;
    const Ran up = run({"sim", "up", file_, "--fleet", name_, "--detach"});
    if (up.code == 5) GTEST_SKIP() << "no network namespaces here: " << up.err;
    ASSERT_EQ(up.code, 0) << up.out << up.err;
    EXPECT_THAT(up.out, HasSubstr("2 of 2 links are up"));
  }
  void TearDown() override {
    if (::geteuid() == 0) run({"sim", "down", name_});
    fs::remove(file_);
  }

  static Ran run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    return finish(
        ChildProcess::start(std::move(arguments), {.environment = {"TIMS_HOST="}, .folder = {}}));
  }
  // Runs timsctl at a host of the fleet.
  Ran on(const std::string& host, const std::vector<std::string>& arguments) const {
    std::vector<std::string> all = {"sim", "exec", "--fleet", name_, host, TIMSCTL_PROGRAM};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run(all);
  }
  [[nodiscard]] Ran fault(const std::vector<std::string>& faults) const {
    std::vector<std::string> all = {"sim", "fault", "--fleet", name_, "robot1-base"};
    all.insert(all.end(), faults.begin(), faults.end());
    return run(all);
  }
  // Whether the base knows a route to the server on the robot's arm.
  [[nodiscard]] bool reachable() const {
    return on("base", {"route", "get", "Test/1/0"}).code == 0;
  }
  [[nodiscard]] json::object state() const {
    const auto lines = json_lines(run({"sim", "show", name_, "--json"}).out);
    if (lines.empty()) return {};
    return lines[0].at("items").at(0).as_object();
  }
  [[nodiscard]] std::vector<std::string> namespaces() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator("/run/netns"))
      if (entry.path().filename().string().starts_with("tims-" + name_ + "-"))
        names.push_back(entry.path().filename());
    return names;
  }
  [[nodiscard]] std::string folder() const { return "/run/tims-sim/" + name_; }

  const std::string name_ = "t" + std::to_string(::getpid());
  const std::string file_ = testing::TempDir() + name_ + ".toml";
};

TEST_F(FleetTest, ShowsHostsAndRemovesEverythingAtTheEnd) {
  const json::object fleet = state();
  EXPECT_EQ(fleet.at("state"), "running");
  EXPECT_EQ(fleet.at("hosts").as_array().size(), 3U);
  EXPECT_EQ(namespaces().size(), 3U);
  const Ran table = run({"sim", "show", name_});
  EXPECT_THAT(table.out, HasSubstr("10.1.1.2/24"));
  EXPECT_THAT(table.out, HasSubstr(folder() + "/robot1-arm/router.sock"));
  EXPECT_TRUE(eventually([&] { return reachable(); }, "the server is known at the base"));

  for (const std::string host : {"base", "robot1-main", "robot1-arm"}) {
    const Ran links = on(host, {"link", "show", "--json"});
    EXPECT_THAT(links.out, HasSubstr(R"("secure":true)")) << host << links.err;
    EXPECT_THAT(links.out, testing::Not(HasSubstr(R"("secure":false)"))) << host;
  }

  const Ran again = run({"sim", "up", file_, "--fleet", name_});
  EXPECT_EQ(again.code, 5);
  EXPECT_THAT(again.err, HasSubstr("is already running"));

  EXPECT_EQ(run({"sim", "down", name_}).code, 0);
  EXPECT_TRUE(namespaces().empty());
  EXPECT_FALSE(fs::exists(folder()));
  EXPECT_EQ(run({"sim", "down", name_}).code, 4);
}

TEST_F(FleetTest, ALineIsCutAndRestored) {
  ASSERT_TRUE(eventually([&] { return reachable(); }, "the server is known at the base"));
  EXPECT_EQ(fault({"cut"}).code, 0);
  EXPECT_TRUE(eventually([&] { return !reachable(); }, "what the robot announced is withdrawn"));
  EXPECT_EQ(state().at("lines").at(0).at("state"), "cut");
  EXPECT_EQ(fault({"heal"}).code, 0);
  EXPECT_TRUE(eventually([&] { return reachable(); }, "the robot is reachable again"));

  EXPECT_EQ(fault({"blackout", "direction=up"}).code, 0);
  EXPECT_TRUE(eventually([&] { return !reachable(); },
                         "a link that works in one direction only goes down"));
  EXPECT_EQ(fault({"off"}).code, 0);
  EXPECT_TRUE(eventually([&] { return reachable(); }, "the robot is reachable again"));
}

TEST_F(FleetTest, LossAndRateAreSetInTheKernelAndDelayIsAdded) {
  ASSERT_TRUE(eventually([&] { return reachable(); }, "the server is known at the base"));
  const Ran ran = fault({"loss=1%", "rate=20Mbit", "delay=30ms"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("loss 1% delay 30ms rate 20Mbit"));
  EXPECT_TRUE(eventually(
      [&] {
        const auto lines = json_lines(on("base", {"ping", "Test/1/0", "-n", "1", "--json"}).out);
        return !lines.empty() && lines.back().contains("rtt_min_s") &&
               lines.back().at("rtt_min_s").to_number<double>() > 0.055;
      },
      "a round trip takes twice the delay"));
  EXPECT_EQ(fault({"los=1%"}).code, 2);
  EXPECT_EQ(run({"sim", "fault", "--fleet", name_, "robot1-bas", "cut"}).code, 4);
}

TEST_F(FleetTest, AHostIsKilledAndStarted) {
  ASSERT_TRUE(eventually([&] { return reachable(); }, "the server is known at the base"));
  EXPECT_EQ(run({"sim", "kill", "--fleet", name_, "robot1-main", "router"}).code, 0);
  EXPECT_EQ(state().at("hosts").at(1).at("programs").at(0).at("state"), "ended");
  EXPECT_TRUE(eventually([&] { return !reachable(); }, "the base notices"));
  EXPECT_EQ(run({"sim", "start", "--fleet", name_, "robot1-main"}).code, 0);
  EXPECT_TRUE(eventually([&] { return reachable(); }, "the arm is known again"));
  EXPECT_EQ(run({"sim", "kill", "--fleet", name_, "robot1-leg"}).code, 4);

  EXPECT_EQ(run({"sim", "kill", "--fleet", name_, "robot1-arm", "server"}).code, 0);
  EXPECT_TRUE(eventually([&] { return !reachable(); }, "the base notices"));
  const Ran unknown = run({"sim", "kill", "--fleet", name_, "robot1-arm", "servant"});
  EXPECT_EQ(unknown.code, 4);
  EXPECT_THAT(unknown.err, HasSubstr("servant"));
}

TEST_F(FleetTest, TheNextFleetRemovesTheRemainsOfACrash) {
  const auto pid = static_cast<pid_t>(state().at("pid").as_int64());
  const auto router =
      static_cast<pid_t>(state().at("hosts").at(0).at("programs").at(0).at("pid").as_int64());
  ASSERT_EQ(::kill(pid, SIGKILL), 0);
  EXPECT_TRUE(eventually([&] { return ::kill(router, 0) != 0; }, "its routers end with it"));
  EXPECT_EQ(state().at("state"), "crashed");
  EXPECT_EQ(namespaces().size(), 3U);
  const Ran up = run({"sim", "up", file_, "--fleet", name_, "--detach"});
  EXPECT_EQ(up.code, 0) << up.err;
  EXPECT_THAT(up.err, HasSubstr("removed the remains of a crash"));
  EXPECT_EQ(state().at("state"), "running");

  ASSERT_EQ(::kill(static_cast<pid_t>(state().at("pid").as_int64()), SIGKILL), 0);
  EXPECT_TRUE(eventually([&] { return state().at("state") == "crashed"; }, "it is gone"));
  const Ran down = run({"sim", "down", name_});
  EXPECT_EQ(down.code, 0);
  EXPECT_THAT(down.err, HasSubstr("leftovers removed"));
  EXPECT_TRUE(namespaces().empty());
}

}  // namespace fleet_test
}  // namespace tims::test

#include "tools/sim/plan.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace timsctl::sim {
namespace plan_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

Plan plan() {
  const FleetFile file = read_fleet({"f", R"toml(
name = "demo"
[base]
settings = ["log.level=debug"]
[[robot]]
count = 2
hosts = ["main", "arm"]
[host.arm]
components = ["tims-demo server --at Test({system}/0)"]
)toml"});
  EXPECT_TRUE(file.problems.empty());
  return make_plan(file.fleet);
}

TEST(Plan, HostsHaveNamespacesAndAddresses) {
  const Plan p = plan();
  ASSERT_EQ(p.hosts.size(), 5U);
  EXPECT_EQ(p.hosts[0].network, "tims-demo-base");
  EXPECT_THAT(p.hosts[0].addresses, ElementsAre("10.0.0.254/24"));
  EXPECT_THAT(p.hosts[0].settings, ElementsAre("log.level=debug"));
  const PlannedHost& main = *p.find_host("robot2-main");
  EXPECT_THAT(main.addresses, ElementsAre("10.0.0.2/24", "10.2.1.1/24"));
  EXPECT_EQ(main.socket(), "/run/tims-sim/demo/robot2-main/router.sock");
  const PlannedHost& arm = *p.find_host("robot2-arm");
  EXPECT_THAT(arm.addresses, ElementsAre("10.2.1.2/24"));
  EXPECT_THAT(arm.components.at(0).command,
              ElementsAre("tims-demo", "server", "--at", "Test(2/0)"));
}

TEST(Plan, EveryRouterAcceptsItsConfiguration) {
  for (const PlannedHost& host : plan().hosts) {
    const auto loaded = tims::config::load(
        {.files = {{"router.toml", host.router_config}}, .settings = {}, .host = {}});
    for (const auto& problem : loaded.problems) ADD_FAILURE() << host.name << problem.to_string();
    EXPECT_EQ(loaded.config.router.name, host.name);
    EXPECT_TRUE(loaded.config.sim.faults);
  }
}

TEST(Plan, RoutersHaveKeysUnlessEverybodyIsTrusted) {
  const auto config_of = [](const Plan& p) {
    return tims::config::load(
               {.files = {{"f", p.hosts[1].router_config}}, .settings = {}, .host = {}})
        .config;
  };
  const auto with_keys = config_of(plan());
  EXPECT_EQ(with_keys.security.keys, "/run/tims-sim/demo/robot1-main/keys");
  EXPECT_FALSE(with_keys.security.insecure);
  const FleetFile file = read_fleet({"f", "[[robot]]\n"});
  const auto without = config_of(make_plan(file.fleet, Trust::kEverybody));
  EXPECT_EQ(without.security.keys, "");
  EXPECT_TRUE(without.security.insecure);
}

TEST(Plan, RobotFilesRunFromTheConfigurationOfTheirHost) {
  const FleetFile file = read_fleet({"f", R"toml(
name = "demo"
[[robot]]
system = 3
[host.main]
components = ["tims-demo ladar"]
robots = ["../robots/sim.toml", "arm.toml"]
)toml"});
  EXPECT_TRUE(file.problems.empty());
  const PlannedHost main = *make_plan(file.fleet).find_host("robot3-main");
  EXPECT_THAT(main.robots, ElementsAre("../robots/sim.toml", "arm.toml"));
  EXPECT_EQ(main.config_file(), "/run/tims-sim/demo/robot3-main/etc/router.toml");
  ASSERT_EQ(main.components.size(), 3U);
  EXPECT_EQ(main.components[1].label, "timsctl up sim.toml");
  EXPECT_THAT(main.components[1].command,
              ElementsAre("timsctl", "up", "/run/tims-sim/demo/robot3-main/etc/robots/sim.toml"));
}

TEST(Plan, LinksGoUpTheTree) {
  const Plan p = plan();
  const auto config = [&](std::string_view host) {
    return tims::config::load(
               {.files = {{"f", p.find_host(host)->router_config}}, .settings = {}, .host = {}})
        .config;
  };
  EXPECT_EQ(config("base").router.role, tims::config::Role::kTop);
  const auto main = config("robot1-main");
  EXPECT_EQ(main.router.role, tims::config::Role::kSystem);
  ASSERT_EQ(main.links.size(), 2U);
  EXPECT_EQ(main.links[0].to_string(), "10.0.0.254:2010");
  EXPECT_EQ(main.links[1].to_string(), "sub of system 1");
  const auto arm = config("robot1-arm");
  EXPECT_EQ(arm.router.role, tims::config::Role::kSubsystem);
  EXPECT_EQ(arm.router.id, 2);
  EXPECT_EQ(arm.links.at(0).to_string(), "10.1.1.1:2010");
}

TEST(Plan, NothingIsMadeOutsideOfNamespaces) {
  const Plan p = plan();
  const std::string commands = network_commands(p);
  EXPECT_THAT(commands, HasSubstr("netns add tims-demo-robot1-arm\n"));
  EXPECT_THAT(commands,
              HasSubstr("link add name robot1 netns tims-demo-base type veth peer name base netns "
                        "tims-demo-robot1-main\n"));
  EXPECT_THAT(commands,
              HasSubstr("link add name arm netns tims-demo-robot2-main type veth peer name main "
                        "netns tims-demo-robot2-arm\n"));
}

TEST(Plan, TheBaseIsABridge) {
  const Plan p = plan();
  const std::string base = host_commands(p, p.hosts[0]);
  EXPECT_THAT(base, HasSubstr("link add name wifi type bridge\n"));
  EXPECT_THAT(base, HasSubstr("address add 10.0.0.254/24 dev wifi\n"));
  EXPECT_THAT(base, HasSubstr("link set dev robot2 master wifi\n"));
  const std::string main = host_commands(p, p.hosts[1]);
  EXPECT_THAT(main, HasSubstr("address add 10.0.0.1/24 dev base\n"));
  EXPECT_THAT(main, HasSubstr("address add 10.1.1.1/24 dev arm\n"));
  EXPECT_THAT(main, Not(HasSubstr("bridge")));
}

// --- what makes lines bad

constexpr double kTenth = 0.1;

TEST(Rules, LossIsThrownAwayWhereItArrives) {
  const LineEnd end = plan().lines[0].lower;
  EXPECT_EQ(dropping(end, {}), "table netdev tims_base\ndelete table netdev tims_base\n");
  EXPECT_EQ(dropping(end, {.loss = kTenth}), R"toml(table netdev tims_base
delete table netdev tims_base
table netdev tims_base {
  chain faults {
    type filter hook ingress device "base" priority 0;
    numgen random mod 1000000 < 100000 drop
  }
}
)toml");
  EXPECT_THAT(dropping(end, {.blackout = true}), HasSubstr("    drop\n"));
}

TEST(Rules, TheRateIsHeldWhereItLeaves) {
  const LineEnd end = plan().lines[0].upper;
  EXPECT_THAT(shaping(end, {}, false), ElementsAre("tc", "-n", "tims-demo-base", "qdisc", "replace",
                                                   "dev", "robot1", "root", "noqueue"));
  EXPECT_THAT(fmt::format("{}", fmt::join(shaping(end, {.rate_bits = 8'000'000}, false), " ")),
              HasSubstr("root tbf rate 8000000bit burst 5000 latency 100ms"));
}

TEST(Rules, DelayIsTheRoutersUnlessTheKernelHasNetem) {
  using namespace std::chrono_literals;
  const LineEnd end = plan().lines[0].upper;
  const Quality late{.duplicate = kTenth, .delay = 20ms, .jitter = 4ms};
  EXPECT_TRUE(needs_router(late));
  EXPECT_FALSE(needs_router({.loss = kTenth, .rate_bits = 8'000'000}));
  EXPECT_EQ(shaping(end, late, false).back(), "noqueue");
  EXPECT_THAT(fmt::format("{}", fmt::join(shaping(end, late, true), " ")),
              HasSubstr("root netem delay 22.000ms 2.000ms duplicate 10%"));
  const json::object question = router_faults("base", late);
  EXPECT_EQ(question.at("link"), "base");
  EXPECT_DOUBLE_EQ(question.at("delay_s").as_double(), 0.02);
}

TEST(Rules, ARouterAloneDoesEverythingItself) {
  const json::object question =
      all_faults("base", {.loss = kTenth, .rate_bits = 8'000'000, .blackout = true});
  EXPECT_EQ(question.at("link"), "base");
  EXPECT_DOUBLE_EQ(question.at("loss").as_double(), kTenth);
  EXPECT_EQ(question.at("rate"), 1'000'000);
  EXPECT_EQ(question.at("blackout"), true);
  EXPECT_FALSE(all_faults("", {}).contains("link"));
}

TEST(Plan, ProgramsOfAHostFindWhatIsTheHosts) {
  EXPECT_EQ(environment_at("/run/tims-sim/demo/base/router.sock"),
            (std::vector<std::string>{"TIMS_ROUTER=/run/tims-sim/demo/base/router.sock",
                                      "TIMS_HOST=", "XDG_RUNTIME_DIR=/run/tims-sim/demo/base"}));
}

}  // namespace plan_test
}  // namespace timsctl::sim

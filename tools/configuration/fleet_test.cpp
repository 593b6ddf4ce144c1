#include "tools/configuration/fleet.h"

#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace timsctl::configuration {
namespace fleet_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const Description* describe(const std::string& program) {
  static const auto of = [](const char* text) {
    return *description_of(boost::json::parse(text).as_object());
  };
  static const Description kLadar =
      of(R"({"rack_description": 1, "program": "Ladar", "class": "Ladar", "class_id": 20,
        "parameters": [{"name": "periodTime", "type": "int", "default": 100},
                       {"name": "dataTaskPrio", "type": "int", "default": 1}],
        "outputs": [{"class": "Ladar", "period": "periodTime", "default_ms": 100}]})");
  static const Description kPilot =
      of(R"({"rack_description": 1, "program": "Pilot", "class": "Pilot", "class_id": 24,
        "parameters": [{"name": "targetStatus", "type": "int", "default": 0},
                       {"name": "ladarSys", "type": "int", "default": 0},
                       {"name": "ladarInst", "type": "int", "default": 0},
                       {"name": "chassisSys", "type": "int", "default": 0},
                       {"name": "chassisInst", "type": "int", "default": -1}],
        "inputs": [{"class": "Ladar", "system": "ladarSys", "instance": "ladarInst"},
                   {"class": "Chassis", "system": "chassisSys", "instance": "chassisInst", "optional": true}]})");
  if (program == "Ladar") return &kLadar;
  return program == "Pilot" ? &kPilot : nullptr;
}

std::string router(const std::string& name, const std::string& role, int system, int id, int port,
                   const std::string& more) {
  return "[router]\nname = \"" + name + "\"\nrole = \"" + role +
         "\"\nsystem = " + std::to_string(system) + "\nid = " + std::to_string(id) +
         "\n[udp]\nlisten = \"127.0.0.1:" + std::to_string(port) + "\"\n" + more;
}
std::string link(const std::string& kind, const std::string& more) {
  return "[[link]]\nkind = \"" + kind + "\"\n" + more + "\n";
}

FleetHost host(const std::string& name, const std::string& router_text,
               const std::string& robot = {}) {
  const auto loaded = tims::config::load(
      {.files = {{name, router_text}}, .settings = {}, .host = {.name = name, .environment = {}}});
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.problems.front().to_string());
  FleetHost made{.name = name, .router = loaded.config};
  if (!robot.empty())
    made.robots.push_back({.name = "robots/r.toml", .text = "system = 1\n" + robot});
  return made;
}

constexpr const char* kLadarAt10Ms =
    "[[component]]\nprogram = \"Ladar\"\nparameters = { periodTime = 10, dataTaskPrio = 29 }\n";
constexpr const char* kPilotOfIt =
    "[[component]]\nprogram = \"Pilot\"\nparameters = { ladarSys = 1 }\n";

// base above main, main above arm.
std::vector<FleetHost> three_hosts(const std::string& rate = "rate = \"1MB\"") {
  return {
      host("base", router("base", "top", 0, 1, 3001, link("sub", "system = \"*\""))),
      host("main",
           router("main", "system", 1, 1, 3002,
                  link("super", "to = \"127.0.0.1:3001\"") + link("sub", "system = 1\n" + rate)),
           kPilotOfIt),
      host(
          "arm",
          router("arm", "subsystem", 1, 2, 3003, link("super", "to = \"127.0.0.1:3002\"\n" + rate)),
          kLadarAt10Ms)};
}

std::string problems(const FleetReport& report) {
  std::string text;
  for (const Finding& each : report.findings) text += each.host + ": " + each.text + "\n";
  return text;
}

TEST(Fleet, ASoundOneHasNoProblemsAndItsLeavesComeFirst) {
  const FleetReport report = check_fleet(three_hosts(), describe);
  EXPECT_EQ(problems(report), "");
  EXPECT_THAT(report.order, ElementsAre("arm", "main", "base"));
}

TEST(Fleet, BudgetsAreTheLargestMessagesTimesTheirRateOnEachHop) {
  const FleetReport report = check_fleet(three_hosts(), describe);
  ASSERT_EQ(report.edges.size(), 1U);
  EXPECT_EQ(report.edges[0].to, "Ladar(1/0)");
  EXPECT_EQ(report.edges[0].to_host, "arm");
  EXPECT_EQ(report.edges[0].period_ms, 10);
  ASSERT_GT(report.edges[0].bytes_max, 1000U);
  const double expected = static_cast<double>(report.edges[0].bytes_max) * 100;
  ASSERT_EQ(report.links.size(), 4U);
  for (const LinkBudget& each : report.links) {
    const bool carries = each.host == "arm" && each.other == "main";
    EXPECT_DOUBLE_EQ(each.worst_sum(), carries ? expected : 0) << each.host << each.other;
    if (!carries) continue;
    EXPECT_EQ(each.rate, 1'000'000U);
    EXPECT_DOUBLE_EQ(each.worst.at(4), expected) << "priority 29";
  }
}

TEST(LinkBudget, IsYellowFrom70AndRedFrom100Percent) {
  LinkBudget link{.rate = 1000, .reserve_percent = 10};
  const auto level = [&](std::size_t message_class, double bytes) {
    link.worst = {};
    link.worst.at(message_class) = bytes;
    return link.level();
  };
  EXPECT_EQ(level(7, 699), "ok");
  EXPECT_EQ(level(7, 700), "yellow");
  EXPECT_EQ(level(7, 999), "yellow");
  EXPECT_EQ(level(7, 1000), "red");
  EXPECT_EQ(level(3, 629), "ok");
  EXPECT_EQ(level(3, 631), "yellow") << "of what the reserve leaves";
  EXPECT_EQ(level(3, 900), "red");
  link.worst = {};
  link.measured = 1000;
  EXPECT_EQ(link.level(), "red");
  link.rate = 0;
  EXPECT_EQ(link.level(), "ok") << "no limit";
}

TEST(Fleet, OneOwnerAnAddress) {
  auto hosts = three_hosts();
  hosts[1].robots.push_back(
      {.name = "robots/x.toml", .text = std::string("system = 1\n") + kLadarAt10Ms});
  EXPECT_THAT(problems(check_fleet(hosts, describe)),
              HasSubstr("arm: Ladar(1/0) also runs as Ladar on main (robots/x.toml:2)"));
}

TEST(Fleet, ReferencesLeadSomewhere) {
  auto hosts = three_hosts();
  hosts[2].robots.clear();
  EXPECT_THAT(problems(check_fleet(hosts, describe)),
              HasSubstr("main: Pilot uses Ladar(1/0), which no host has"));
}

TEST(Fleet, OnePilotAChassisFromTheStart) {
  auto hosts = three_hosts();
  const std::string on =
      "system = 1\n[[component]]\nprogram = \"Pilot\"\ninstance = N\n"
      "parameters = { ladarSys = 1, chassisInst = 0, targetStatus = 1 }\n";
  std::string first = on;
  std::string second = on;
  first.replace(first.find('N'), 1, "1");
  second.replace(second.find('N'), 1, "2");
  hosts[1].robots = {{.name = "robots/a.toml", .text = first}};
  EXPECT_THAT(problems(check_fleet(hosts, describe)), Not(HasSubstr("one pilot")));
  hosts[1].robots.push_back({.name = "robots/b.toml", .text = second});
  EXPECT_THAT(problems(check_fleet(hosts, describe)), HasSubstr("one pilot a chassis"));
}

TEST(Fleet, OneTopRouterAndAWayToEachSuperRouter) {
  auto hosts = three_hosts();
  hosts[1].router->router.role = tims::config::Role::kTop;
  EXPECT_THAT(problems(check_fleet(hosts, describe)),
              HasSubstr("a fleet has one top router, not 2: base, main"));
  hosts = three_hosts();
  hosts[2].router->links.clear();
  EXPECT_THAT(problems(check_fleet(hosts, describe)), HasSubstr("arm: no way to the super router"));
  hosts = three_hosts();
  hosts[1].router->links[1].system = 7;
  EXPECT_THAT(problems(check_fleet(hosts, describe)),
              HasSubstr("main: accepts no sub router of system 1"));
}

TEST(Fleet, OneSetOfWidths) {
  auto hosts = three_hosts();
  hosts[2].router->address.widths = {10, 6, 8, 8};
  EXPECT_THAT(problems(check_fleet(hosts, describe)), HasSubstr("arm: address.widths differ"));
}

TEST(Fleet, ACircleOfRoutersEnds) {
  auto hosts = three_hosts();
  hosts.erase(hosts.begin());
  hosts[0].router->links[0].port = 3003;  // main above arm above main
  EXPECT_EQ(check_fleet(hosts, describe).order.size(), 2U);
}

}  // namespace fleet_test
}  // namespace timsctl::configuration

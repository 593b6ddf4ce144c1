// Dora's own files, started as users do on one host and without `rack-dora`: nobody tells her where
// she is. Her first fix places her, the map gives her heading, and she drives along her route.
#include <cmath>
#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rack/proxies/chassis.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"
#include "tests/system/sample_robot_fixture.h"

namespace tims::test {
namespace dora_files_test {

class DoraFilesTest : public SampleRobotTest {
 protected:
  void SetUp() override {
    SampleRobotTest::SetUp();
    for (const auto& [file, programs] :
         {std::pair{"base", 2}, {"drive", 5}, {"laser", 3}, {"nav", 3}})
      start_part(TIMS_ROBOTS "/dora-" + std::string(file) + ".toml", programs);
    ASSERT_TRUE(turned_on(of_system("World")));
  }
  void TearDown() override {
    while (!parts_.empty()) {
      const auto ended = parts_.back()->stop(SIGINT, kDrive);
      EXPECT_TRUE(ended) << ended.error().message();
      parts_.pop_back();
    }
  }
  void start_part(const std::string& file, int programs) {
    parts_.push_back(std::make_unique<ChildProcess>(begin({"up", file, "--system", system_})));
    const auto ready = parts_.back()->wait_for_line(" programs are ready", kDrive);
    ASSERT_TRUE(ready) << ready.error().message() << parts_.back()->output();
    const std::string all = std::to_string(programs);
    ASSERT_THAT(*ready, testing::HasSubstr(all + " of " + all + " programs are ready"));
  }

  struct Errors {
    double distance = 1e9;  // mm, of Position from the truth
    double turn = 4;        // rad
    double deviation = 0;   // mm, that Position reports
    double driven = 0;      // mm, from where the world has placed her
  };
  Errors errors() {
    const auto believed = of_robot<rack::PositionProxy>("Position").get_data();
    const auto now = truth();
    const auto* const dora = now.find(rack::world_thing::kRobot, "dora");
    if (!believed || dora == nullptr) return {};
    return {
        .distance = std::hypot(believed->pos.x.raw() - dora->pos.x.raw(),
                               believed->pos.y.raw() - dora->pos.y.raw()),
        .turn = std::abs(
            std::remainder(believed->pos.rho.raw() - dora->pos.rho.raw(), 2 * std::numbers::pi)),
        .deviation = static_cast<double>(std::max(believed->var.x.raw(), believed->var.y.raw())),
        .driven = std::hypot(dora->pos.x.raw() - 223023, dora->pos.y.raw() - 119790)};
  }
  // Until this holds; the answer shows where she is.
  template <typename Holds>
  testing::AssertionResult comes(const std::string& what, Holds holds) {
    return eventually(
        [&]() -> std::string {
          const Errors now = errors();
          if (holds(now)) return "";
          return what + ": " + std::to_string(now.distance) + " mm and " +
                 std::to_string(now.turn) + " rad wrong, deviation " +
                 std::to_string(now.deviation) + " mm, " + std::to_string(now.driven) +
                 " mm driven";
        },
        2 * kDrive);
  }

  // As users do: a chassis without CPU time for seconds has to be given its pilot again.
  void keep_going() {
    auto chassis = of_robot<rack::ChassisProxy>("Chassis");
    const Address pilot = *Address::parse(of_system("Pilot"));
    const auto data = chassis.get_data();
    if (!data || data->activePilot != pilot) (void)chassis.set_active_pilot(pilot);
    auto driving = of_robot<rack::PilotProxy>("Pilot");
    const auto status = driving.status();
    if (status && *status != rack::Status::kEnabled) (void)driving.on();
  }

  std::vector<std::unique_ptr<ChildProcess>> parts_;
};

TEST_F(DoraFilesTest, SheStartsByHerFirstFixAndDrives) {
  ASSERT_TRUE(turned_on(of_system("Position")));
  EXPECT_GT(errors().deviation, 50'000) << "unknown at the start";
  ASSERT_TRUE(turned_on(of_system("Mcl")));
  ASSERT_TRUE(turned_on(of_system("Gps")));
  ASSERT_TRUE(comes("by satellites", [](const Errors& now) { return now.distance < 5000; }));
  ASSERT_TRUE(comes("by the map", [](const Errors& now) {
    return now.distance < 500 && now.turn < 0.1 && now.deviation < 500;
  }));
  ASSERT_TRUE(turned_on(of_system("Path")));
  ASSERT_TRUE(turned_on(of_system("Chassis")));
  EXPECT_TRUE(comes("along the route", [&](const Errors& now) {
    keep_going();
    return now.driven > 30'000;
  }));
  EXPECT_LT(errors().distance, 1000);
}

}  // namespace dora_files_test
}  // namespace tims::test

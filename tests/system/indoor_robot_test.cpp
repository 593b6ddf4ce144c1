// The indoor robot of the samples: real drivers in a simulated world, which localises on its floor
// plan and is sent to a place among people. What it reaches is judged by the truth, not by what it
// believes.
#include <cmath>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "rack/proxies/mcl.h"
#include "rack/proxies/world.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace {

using testing::HasSubstr;

constexpr Duration kDrive = 4 * kPatience;

// Terminals have the system's number: another run of this test has another.
const std::string kSystem = std::to_string(100 + ::getpid() % 100);

class IndoorRobotTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    up_ = std::make_unique<ChildProcess>(
        begin({"up", TIMS_ROBOTS "/emulated.toml", "--system", kSystem}));
    const auto ready = up_->wait_for_line(" programs are ready", kDrive);
    ASSERT_TRUE(ready) << ready.error().message();
    ASSERT_THAT(*ready, HasSubstr("12 of 12 programs are ready")) << up_->output();
    ASSERT_TRUE(turned_on("World(" + kSystem + "/0)"));
  }
  void TearDown() override {
    const auto ended = up_->stop(SIGINT, kDrive);
    EXPECT_TRUE(ended) << ended.error().message();
    EXPECT_EQ(ended ? ended->code : -1, 0) << up_->output();
  }

  ChildProcess begin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(TIMS_PROGRAMS) + "/timsctl");
    ChildOptions options = at_router();
    options.environment.push_back("XDG_RUNTIME_DIR=" + router_.folder());
    auto child = ChildProcess::start(std::move(arguments), options);
    EXPECT_TRUE(child) << child.error().message();
    return std::move(child).value();
  }
  template <typename Proxy>
  Proxy of_robot(const std::string& name) {
    return proxy<Proxy>(name + "(" + kSystem + "/0)");
  }

  std::unique_ptr<ChildProcess> up_;
};

TEST_F(IndoorRobotTest, LocalisesIsSentToAPlaceAmongPeopleAndArrives) {
  // On a machine that is very busy streams break, its pilot with them: then it is sent once more.
  const auto arrives = [&]() -> std::string {
    ChildProcess drive = begin({"nav", "goto", "3.5", "3", "90", "--timeout", "20s"});
    const auto ended = drive.wait(kDrive);
    return ended && ended->code == 0 ? "" : drive.output();
  };
  ASSERT_TRUE(eventually(arrives, kDrive)) << up_->output();

  const auto truth = of_robot<rack::WorldProxy>("World").get_data();
  ASSERT_TRUE(truth) << truth.error().message();
  const auto* const is = truth->find(rack::world_thing::kRobot, "scout");
  ASSERT_NE(is, nullptr);
  EXPECT_LT(std::hypot(is->pos.x.raw() - 3500, is->pos.y.raw() - 3000), 300);
  EXPECT_EQ(is->contacts(), 0U) << "people who walk against it are not its doing";
  EXPECT_GT(is->way.raw(), 4000);
  EXPECT_EQ(truth->peopleMove, 1);

  const auto believed = of_robot<rack::MclProxy>("Mcl").get_data();
  ASSERT_TRUE(believed) << believed.error().message();
  EXPECT_LT(
      std::hypot(believed->pos.x.raw() - is->pos.x.raw(), believed->pos.y.raw() - is->pos.y.raw()),
      200);
}

}  // namespace
}  // namespace tims::test

#include "tests/chaos/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::chaos {
namespace plan_test {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::vector<std::string> texts(const Round& round) {
  std::vector<std::string> all;
  for (const Step& step : round.steps) {
    all.push_back(std::to_string(step.at.count()));
    all.insert(all.end(), step.arguments.begin(), step.arguments.end());
  }
  return all;
}

TEST(Plan, IsDeterminedByTheSeed) {
  const Shape shape = make_shape(3);
  EXPECT_EQ(texts(plan_round(7, 1, shape, 10s)), texts(plan_round(7, 1, shape, 10s)));
  EXPECT_NE(texts(plan_round(7, 1, shape, 10s)), texts(plan_round(7, 2, shape, 10s)));
  EXPECT_NE(texts(plan_round(7, 1, shape, 10s)), texts(plan_round(8, 1, shape, 10s)));
}

TEST(Plan, StepsAreInOrderAndKillOnlyInRoundsWithKills) {
  const Shape shape = make_shape(2);
  bool any_kill = false;
  for (std::size_t number = 0; number < 50; ++number) {
    const Round round = plan_round(3, number, shape, 10s);
    EXPECT_GE(round.span, 5s);
    EXPECT_LE(round.span, 10s);
    Duration last{};
    for (const Step& step : round.steps) {
      EXPECT_GE(step.at, last);
      EXPECT_LE(step.at, round.span);
      last = step.at;
      if (step.arguments.front() != "kill") continue;
      EXPECT_TRUE(round.kills);
      any_kill = true;
    }
  }
  EXPECT_TRUE(any_kill);
}

TEST(Plan, TheShapeFindsTheNextHostDown) {
  const Shape shape = make_shape(2);  // base, robot1-main, robot1-arm, robot2-main, robot2-arm
  ASSERT_EQ(shape.hosts.size(), 5U);
  EXPECT_EQ(shape.next_down(0, 4), 3U);
  EXPECT_EQ(shape.next_down(3, 4), 4U);
  EXPECT_EQ(shape.next_down(4, 4), 4U);
  EXPECT_EQ(shape.next_down(1, 4), std::nullopt);
  EXPECT_EQ(shape.client_address(8).to_string(), "Test(2/8)");
}

TEST(Plan, TheFleetFileNumbersTheClients) {
  const std::string text = fleet_file(make_shape(1), "chaos client {} /board");
  EXPECT_THAT(text, HasSubstr("[base]\ncomponents = [\"chaos client 0 /board\", "
                              "\"chaos client 1 /board\"]"));
  EXPECT_THAT(text, HasSubstr("components.arm = [\"chaos client 4 /board\", "
                              "\"chaos client 5 /board\"]"));
}

}  // namespace plan_test
}  // namespace tims::chaos

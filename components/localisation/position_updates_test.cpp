#include "components/localisation/position_updates.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "components/localisation/grid_map.h"

namespace rack::localisation {
namespace position_updates_test {

using Event = PositionUpdates::Event;

// An L of walls without symmetry; the robot stands still at `truth`.
class PositionUpdatesTest : public testing::Test {
 protected:
  PositionUpdatesTest() {
    DxfDrawing plan;
    plan.lines = {{{-2, -2}, {6, -2}}, {{6, -2}, {6, 4}}, {{6, 4}, {-2, 4}},
                  {{-2, 4}, {-2, -2}}, {{2, -2}, {2, 0}}, {{-2, 1}, {-1, 1.5}}};
    map_ = *read_map(plan, 1000, 0, 0, 50);
    field_ = std::make_unique<LikelihoodField>(std::move(LikelihoodField::of(map_, {}).value()));
    for (int i = 0; i < 180; ++i) {
      const double angle = radians(2.0 * i);
      double range = 100;
      while (range < 9000 && is_free(range * std::cos(angle), range * std::sin(angle))) range += 10;
      scan_.push_back({static_cast<float>(range * std::cos(angle)),
                       static_cast<float>(range * std::sin(angle))});
    }
  }

  [[nodiscard]] bool is_free(double x, double y) const {
    const auto at = [](double place, double corner) {
      return static_cast<std::int64_t>((place - corner) / 50);
    };
    const auto row = at(x, map_.origin.x);
    const auto column = at(y, map_.origin.y);
    return row >= 0 && column >= 0 && row < map_.rows && column < map_.columns &&
           map_.at(static_cast<std::int32_t>(row), static_cast<std::int32_t>(column)) !=
               Cell::kOccupied;
  }

  void look(int scans) {
    for (int i = 0; i < scans; ++i) {
      odometry_ = odometry_ + Pose{.rho = 0.11};
      truth_ = truth_ + Pose{.rho = 0.11};
      turned_.clear();
      for (const BeamEnd& end : scan_) {
        const Pose at = Pose{.rho = -truth_.rho} + Pose{.x = 1.0 * end.x, .y = 1.0 * end.y};
        turned_.push_back({static_cast<float>(at.x), static_cast<float>(at.y)});
      }
      localiser_.take(*field_, odometry_, turned_);
    }
  }

  PositionUpdates::Step step(const std::optional<PositionData>& believed) {
    time_ = time_ + std::chrono::milliseconds(1000);
    return updates_.take(localiser_, odometry_, believed, time_, [&](TimeStamp) { return knows_; });
  }
  PositionData believed(double x, i32 deviation) const {
    Pose at = truth_;
    at.x = x;
    PositionData data{.recordingTime = time_, .pos = at.position()};
    data.var.x = data.var.y = deviation;
    return data;
  }
  // It is certain, and Position has its pose.
  void become_certain() {
    localiser_.start_at(truth_, 100, 0.05);
    look(10);
    ASSERT_EQ(step(believed(0, 0)).event, Event::kCertain);
  }

  GridMap map_;
  std::unique_ptr<LikelihoodField> field_;
  std::vector<BeamEnd> scan_;
  std::vector<BeamEnd> turned_;
  Localiser localiser_{{}, 1};
  PositionUpdates updates_;
  Pose truth_{};
  Pose odometry_{.x = 700, .y = 20, .rho = 1};
  TimeStamp time_ = 1000;
  bool knows_ = true;
};

TEST(PositionUpdates, StartsWherePositionIsUnlessNobodyKnows) {
  PositionData known;
  PositionData unknown;
  known.var.x = known.var.y = static_cast<i32>(PositionUpdates::kKnown);
  unknown.var.x = static_cast<i32>(PositionUpdates::kKnown) + 1;
  const auto may = [](const PositionData& position, const Pose& odometry) {
    return PositionUpdates::may_start_at(position, odometry, 500, 0.25);
  };
  EXPECT_TRUE(may(known, {.x = 5000, .y = 3000, .rho = 2}));
  EXPECT_TRUE(may(unknown, {.x = 0, .y = -500, .rho = 0.25})) << "it has not moved yet";
  EXPECT_FALSE(may(unknown, {.x = 501}));
  EXPECT_FALSE(may(unknown, {.rho = 2 * kPi - 0.26}));
}

TEST_F(PositionUpdatesTest, ACertainPoseIsSentEachTime) {
  become_certain();
  for (int i = 0; i < 3; ++i) {
    look(1);
    const auto next = step(believed(0, 20));
    EXPECT_EQ(next.event, Event::kNone);
    ASSERT_TRUE(next.update);
    EXPECT_LT(std::abs(next.update->pos.x.raw()), 100);
    EXPECT_LT(next.update->var.x, 200);
  }
}

// A Position that was just started believes in its origin.
TEST_F(PositionUpdatesTest, WhileItIsUncertainPositionGetsALargeDeviation) {
  localiser_.start_anywhere();
  const auto first = step(believed(1234, 0));
  EXPECT_EQ(first.event, Event::kNone);
  ASSERT_TRUE(first.update);
  EXPECT_EQ(first.update->pos.x, 1234);
  EXPECT_GE(first.update->var.x, PositionUpdates::kLostDeviation);
  EXPECT_FALSE(step(believed(1234, PositionUpdates::kLostDeviation)).update) << "it is uncertain";
  EXPECT_TRUE(step(believed(1234, 500)).update) << "restarted";
  EXPECT_FALSE(step({}).update) << "nobody knows where Position is";
}

TEST_F(PositionUpdatesTest, ItFollowsAPositionThatAnotherComponentHasUpdated) {
  become_certain();
  EXPECT_EQ(step(believed(PositionUpdates::kJump, 20)).event, Event::kNone);
  const auto far = step(believed(3000, 20));
  EXPECT_EQ(far.event, Event::kFollows);
  EXPECT_NEAR(far.away, 3000, 100);
  EXPECT_FALSE(far.update);
  EXPECT_NEAR(localiser_.pose().x, 3000, 1);
}

TEST_F(PositionUpdatesTest, ItDoesNotFollowWhoIsUncertain) {
  become_certain();
  const auto next = step(believed(3000, 600));
  EXPECT_EQ(next.event, Event::kNone);
  EXPECT_TRUE(next.update);
}

TEST_F(PositionUpdatesTest, ItDoesNotFollowARestartedPosition) {
  become_certain();
  knows_ = false;
  const auto next = step(believed(3000, 0));
  EXPECT_EQ(next.event, Event::kNone);
  ASSERT_TRUE(next.update);
  EXPECT_LT(std::abs(next.update->pos.x.raw()), 100);
}

}  // namespace position_updates_test
}  // namespace rack::localisation

#include "components/vision/fix_gate.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

namespace rack::vision {
namespace fix_gate_test {

RobotFix fix_at(double x, double y, double rho = 0, std::size_t markers = 1) {
  return {.pose = {.x = x, .y = y, .rho = rho},
          .deviation = 30,
          .deviation_rho = 0.01,
          .error = 0.3,
          .markers = markers};
}

class FixGateTest : public testing::Test {
 protected:
  // A picture each 100 ms.
  bool sends(const std::vector<RobotFix>& fixes, const Pose& believed = {}, double deviation = 50) {
    time_ = time_ + std::chrono::milliseconds(100);
    sent_ = gate_.take(time_, fixes, believed, deviation);
    return sent_.has_value();
  }

  FixGate gate_;
  TimeStamp time_ = 0;
  std::optional<RobotFix> sent_;
};

TEST_F(FixGateTest, SendsWhatIsNearAtOnce) {
  EXPECT_TRUE(sends({fix_at(100, 50)}));
  EXPECT_FALSE(sends({fix_at(0, 0, radians(16))}));
  EXPECT_FALSE(sends({fix_at(2000, 0)}));
  EXPECT_TRUE(sends({fix_at(2000, 0)}, {}, 1000)) << "the position is uncertain";
  EXPECT_FALSE(sends({}));
}

TEST_F(FixGateTest, WhatIsKnownBetterIsNotReplaced) {
  EXPECT_FALSE(sends({fix_at(45, 0)}, {}, 20));
  EXPECT_FALSE(sends({fix_at(45, 0)}, {}, 30));
  EXPECT_TRUE(sends({fix_at(45, 0)}, {}, 31));
}

TEST_F(FixGateTest, OfTwoThatFitTheOneThatIsBelieved) {
  ASSERT_TRUE(sends({fix_at(3000, 0), fix_at(20, 0)}));
  EXPECT_EQ(sent_->pose.x, 20);
  EXPECT_FALSE(sends({fix_at(3000, 0), fix_at(20, 0)}, {}, 5000)) << "both are possible";
}

TEST_F(FixGateTest, ARobotThatWasCarriedAwayIsFoundAfterTwoSeconds) {
  Pose believed;
  Pose truth{.x = 5000, .y = 3000, .rho = 2};
  for (int picture = 0; picture <= 20; ++picture) {
    EXPECT_EQ(sends({fix_at(truth.x, truth.y, truth.rho)}, believed), picture == 20) << picture;
    const Pose step{.x = 70, .y = 5, .rho = 0.05};
    truth = truth + step;
    believed = believed + step;
  }
}

TEST_F(FixGateTest, ASingleMarkerMustAgreeLongerWhileTheRobotStands) {
  for (int picture = 0; picture < 50; ++picture) EXPECT_FALSE(sends({fix_at(5000, 0)}));
  EXPECT_TRUE(sends({fix_at(5000, 0)}));
  for (int picture = 0; picture < 30; ++picture) EXPECT_FALSE(sends({fix_at(5000, 0)}));
  EXPECT_TRUE(sends({fix_at(5300, 0)}, {.x = 300})) << "it has moved";
}

TEST_F(FixGateTest, TwoMarkersOrAnUncertainPositionSuffice) {
  int sent = 0;
  for (int picture = 0; picture <= 20; ++picture) sent += sends({fix_at(5000, 0, 0, 2)}) ? 1 : 0;
  EXPECT_EQ(sent, 1);
  for (int picture = 0; picture <= 20; ++picture)
    sent += sends({fix_at(0, 0, 3)}, {}, FixGate::kUncertain) ? 1 : 0;
  EXPECT_EQ(sent, 2);
}

TEST_F(FixGateTest, PicturesThatContradictEachOtherSendNothing) {
  for (int picture = 0; picture < 100; ++picture)
    EXPECT_FALSE(sends({fix_at(picture % 2 == 0 ? 5000 : -5000, 0, 0, 2)}));
  for (int picture = 0; picture < 100; ++picture)
    EXPECT_FALSE(sends({fix_at(5000, 0, 0, 2), fix_at(6000, 0, 0, 2)}));
}

TEST_F(FixGateTest, FewPicturesAreNotEnough) {
  for (int picture = 1; picture < FixGate::kAgreeing; ++picture) {
    time_ = time_ + std::chrono::seconds(5);
    EXPECT_FALSE(sends({fix_at(5000, 0, 0, 2)}));
  }
  EXPECT_TRUE(sends({fix_at(5000, 0, 0, 2)}));
}

}  // namespace fix_gate_test
}  // namespace rack::vision

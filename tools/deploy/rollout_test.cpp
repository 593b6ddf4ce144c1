#include "tools/deploy/rollout.h"

#include <gmock/gmock.h>

namespace timsctl::deploy {
namespace rollout_test {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr tims::Time kNow{};

void prepare(HostRun& host) {
  while (const auto step = host.begin(kNow)) {
    if (*step == Step::kLook)
      host.looked(false, 0);
    else
      host.done();
  }
}

TEST(DeployRollout, NoHostIsChangedBeforeAllAreReady) {
  Rollout rollout({"main", "arm"}, false);
  prepare(rollout.host(0));
  EXPECT_FALSE(rollout.is_ready());
  EXPECT_THAT(rollout.settle(), IsEmpty());
  EXPECT_EQ(rollout.host(0).begin(kNow), std::nullopt);
  prepare(rollout.host(1));
  EXPECT_TRUE(rollout.is_ready());
  rollout.go();
  EXPECT_FALSE(rollout.is_ready());
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(rollout.host(i).begin(kNow), Step::kApply);
}

TEST(DeployRollout, AHostThatCannotBePreparedEndsTheOthers) {
  Rollout rollout({"main", "arm", "eye"}, false);
  prepare(rollout.host(0));
  (void)rollout.host(1).begin(kNow);
  rollout.host(1).lost(kNow, "ssh: no route");
  (void)rollout.host(2).begin(kNow);
  EXPECT_THAT(rollout.settle(), ElementsAre(0U, 2U));
  EXPECT_THAT(rollout.settle(), IsEmpty());
  EXPECT_EQ(rollout.host(0).begin(kNow), Step::kRelease);
  rollout.host(0).done();
  EXPECT_TRUE(rollout.is_over());
  EXPECT_EQ(rollout.host(0).reason(), "arm could not be prepared");
  EXPECT_EQ(rollout.host(1).reason(), "ssh: no route");
  EXPECT_FALSE(rollout.succeeded());
}

TEST(DeployRollout, AHostThatGoesBackLeavesTheOthers) {
  Rollout rollout({"main", "arm"}, false);
  for (std::size_t i = 0; i < 2; ++i) prepare(rollout.host(i));
  rollout.go();
  for (std::size_t i = 0; i < 2; ++i) (void)rollout.host(i).begin(kNow);
  rollout.host(1).applied(End::kWentBack, "doctor: mailboxes.dead");
  EXPECT_THAT(rollout.settle(), IsEmpty());
  EXPECT_FALSE(rollout.is_over());
  rollout.host(0).applied(End::kKept, "");
  EXPECT_TRUE(rollout.is_over());
  EXPECT_FALSE(rollout.succeeded());
  EXPECT_EQ(rollout.host(0).end(), End::kKept);
}

TEST(DeployRollout, IsDoneIfAllRunWhatWasWanted) {
  Rollout rollout({"main", "arm"}, false);
  for (std::size_t i = 0; i < 2; ++i) prepare(rollout.host(i));
  rollout.go();
  for (std::size_t i = 0; i < 2; ++i) (void)rollout.host(i).begin(kNow);
  rollout.host(0).applied(End::kKept, "");
  rollout.host(1).applied(End::kSame, "");
  EXPECT_TRUE(rollout.succeeded());
}

TEST(DeployRollout, ADryRunAndCtrlCChangeNothing) {
  for (const bool dry : {true, false}) {
    Rollout rollout({"main", "arm"}, false);
    for (std::size_t i = 0; i < 2; ++i) prepare(rollout.host(i));
    if (dry)
      rollout.cancel("dry run");
    else
      rollout.stop();
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(rollout.host(i).begin(kNow), Step::kRelease);
      rollout.host(i).done();
      EXPECT_EQ(rollout.host(i).end(), End::kUntouched);
    }
    EXPECT_TRUE(rollout.is_over());
  }
}

}  // namespace rollout_test
}  // namespace timsctl::deploy

#include "tools/deploy/host_run.h"

#include <random>

#include <gtest/gtest.h>

namespace timsctl::deploy {
namespace host_run_test {

using namespace std::chrono_literals;

// A host, and a deployer that does what HostRun says, on a virtual clock. A connection breaks
// before or after the command has had its effect.
struct World {
  HostRun run;
  tims::Time now{};
  int applied = 0;  // jobs that were started
  bool job_over = false;
  std::size_t carried = 0;

  explicit World(bool undo = false) : run(undo) {}

  void effect(Step step) {
    if (step == Step::kApply && !job_over) {
      ++applied;
      job_over = true;
    }
    if (step == Step::kCarry) ++carried;
  }
  void answer(Step step) {
    switch (step) {
      case Step::kLook:
        return run.looked(false, 2);
      case Step::kApply:
        return run.applied(End::kKept, "");
      default:
        return run.done();
    }
  }
  // The next step; the clock goes to it.
  std::optional<Step> begin() {
    if (run.next_begin() == tims::kNever) return std::nullopt;
    now = std::max(now, run.next_begin());
    return run.begin(now);
  }
};

TEST(DeployHost, TakesItsStepsInOrder) {
  World world;
  std::vector<Step> steps;
  while (const auto step = world.begin()) {
    steps.push_back(*step);
    world.effect(*step);
    world.answer(*step);
  }
  EXPECT_EQ(steps, (std::vector{Step::kConnect, Step::kLook, Step::kStage, Step::kCarry,
                                Step::kCarry, Step::kPrepare}));
  EXPECT_TRUE(world.run.is_ready());
  EXPECT_EQ(world.run.next_begin(), tims::kNever) << "it waits for the others";
  world.run.go();
  EXPECT_EQ(world.begin(), Step::kApply);
  world.run.applied(End::kKept, "");
  EXPECT_TRUE(world.run.is_over());
  EXPECT_EQ(world.run.end(), End::kKept);
}

TEST(DeployHost, UndoNeedsNoPackages) {
  World world(true);
  std::vector<Step> steps;
  while (const auto step = world.begin()) {
    steps.push_back(*step);
    world.answer(*step);
  }
  EXPECT_EQ(steps, (std::vector{Step::kConnect, Step::kLook, Step::kStage}));
  EXPECT_TRUE(world.run.is_ready());
}

// Whenever the connection breaks, before or after a command has done its work, the deployment ends
// as if it had not.
TEST(DeployHost, SurvivesABrokenConnectionAtEachStep) {
  constexpr int kSteps = 8;
  for (int broken = 0; broken < kSteps; ++broken)
    for (const bool after : {false, true}) {
      World world;
      int number = 0;
      while (!world.run.is_over()) {
        if (world.run.is_ready()) world.run.go();
        const auto step = world.begin();
        ASSERT_TRUE(step) << "step " << number;
        const bool breaks = number++ == broken && *step != Step::kConnect;
        if (!breaks || after) world.effect(*step);
        if (breaks)
          world.run.lost(world.now, "cut");
        else
          world.answer(*step);
      }
      EXPECT_EQ(world.run.end(), End::kKept) << "broken at step " << broken;
      EXPECT_EQ(world.applied, 1) << "broken at step " << broken;
    }
}

TEST(DeployHost, ConnectionsThatComeAndGo) {
  for (unsigned seed = 1; seed <= 2000; ++seed) {
    std::mt19937 random(seed);
    World world;
    for (int turn = 0; !world.run.is_over() && turn < 1000; ++turn) {
      if (world.run.is_ready()) world.run.go();
      const auto step = world.begin();
      ASSERT_TRUE(step) << "seed " << seed;
      world.now += std::chrono::milliseconds(random() % 3000);
      const auto fate = random() % 4;
      if (fate != 0) world.effect(*step);
      if (fate <= 1 && (world.run.is_connected() || turn > 0))
        world.run.lost(world.now, "cut");
      else
        world.answer(*step);
    }
    ASSERT_TRUE(world.run.is_over()) << "seed " << seed;
    EXPECT_LE(world.applied, 1) << "seed " << seed;
    if (world.run.end() != End::kUnknown) {
      EXPECT_EQ(world.applied, world.run.end() == End::kKept ? 1 : 0) << "seed " << seed;
    }
  }
}

TEST(DeployHost, AHostThatWasNeverReachedIsNotWaitedFor) {
  World world;
  EXPECT_EQ(world.begin(), Step::kConnect);
  world.run.lost(world.now, "no route");
  EXPECT_TRUE(world.run.is_over());
  EXPECT_EQ(world.run.end(), End::kUntouched);
  EXPECT_EQ(world.run.reason(), "no route");
}

// Until it is given up: at the limit, not below.
tims::Duration given_up_after(bool applying) {
  World world;
  for (;;) {
    if (world.run.is_ready()) {
      if (!applying) break;
      world.run.go();
    }
    const auto step = world.begin();
    if (*step == Step::kApply) break;
    world.answer(*step);
    if (!applying && world.run.step() == Step::kPrepare) break;
  }
  if (!applying) (void)world.begin();
  const tims::Time cut = world.now;
  world.run.lost(world.now, "cut");
  while (!world.run.is_over()) {
    EXPECT_EQ(world.begin(), Step::kConnect);
    EXPECT_LE(world.now - cut, kGiveUpApplying + kLongestPause);
    world.run.lost(world.now, "cut");
  }
  EXPECT_EQ(world.run.end(), applying ? End::kUnknown : End::kUntouched);
  return world.now - cut;
}

TEST(DeployHost, ALostHostIsGivenUp) {
  const auto preparing = given_up_after(false);
  EXPECT_GE(preparing, kGiveUp);
  EXPECT_LT(preparing, kGiveUp + kLongestPause);
  const auto applying = given_up_after(true);
  EXPECT_GE(applying, kGiveUpApplying);
  EXPECT_LT(applying, kGiveUpApplying + kLongestPause);
}

TEST(DeployHost, WhatWasSentIsRemovedAfterAFailure) {
  World world;
  while (world.run.step() != Step::kPrepare) world.answer(*world.begin());
  EXPECT_EQ(world.begin(), Step::kPrepare);
  world.run.failed("disk: full");
  EXPECT_EQ(world.run.end(), End::kUntouched);
  EXPECT_EQ(world.begin(), Step::kRelease);
  world.run.failed("that as well");
  EXPECT_TRUE(world.run.is_over());
  EXPECT_EQ(world.run.reason(), "disk: full");
}

// A refusal is one as long as nothing can have begun; once an answer was lost, nobody knows.
TEST(DeployHost, AHostThatRefusesToApply) {
  World refused;
  while (!refused.run.is_ready()) refused.answer(*refused.begin());
  refused.run.go();
  EXPECT_EQ(refused.begin(), Step::kApply);
  refused.run.failed("busy: another deployment has begun here since");
  EXPECT_EQ(refused.run.end(), End::kUntouched);
  EXPECT_EQ(refused.begin(), Step::kRelease);

  World lost;
  while (!lost.run.is_ready()) lost.answer(*lost.begin());
  lost.run.go();
  EXPECT_EQ(lost.begin(), Step::kApply);
  lost.run.lost(lost.now, "cut");
  EXPECT_EQ(lost.begin(), Step::kConnect);
  lost.run.done();
  EXPECT_EQ(lost.begin(), Step::kApply);
  lost.run.failed("busy: another deployment has begun here since");
  EXPECT_EQ(lost.run.end(), End::kUnknown);
  EXPECT_TRUE(lost.run.is_over());
}

TEST(DeployHost, AnInterruptedDeploymentEndsFirst) {
  World world;
  world.answer(*world.begin());
  EXPECT_EQ(world.begin(), Step::kLook);
  world.run.looked(true, 0);
  EXPECT_EQ(world.begin(), Step::kRecover);
  world.run.applied(End::kWentBack, "interrupted");
  EXPECT_EQ(world.begin(), Step::kLook) << "everything there may be different now";
  world.run.looked(false, 0);
  EXPECT_EQ(world.begin(), Step::kStage);

  World broken;
  broken.answer(*broken.begin());
  (void)broken.begin();
  broken.run.looked(true, 0);
  (void)broken.begin();
  broken.run.applied(End::kBroken, "dpkg");
  EXPECT_EQ(broken.run.end(), End::kBroken);
}

TEST(DeployHost, StoppingBeforeItAppliesChangesNothing) {
  for (int steps = 0; steps < 6; ++steps) {
    World world;
    for (int i = 0; i < steps; ++i) world.answer(*world.begin());
    if (!world.run.is_ready()) (void)world.begin();
    world.run.stop();
    EXPECT_EQ(world.run.end(), End::kUntouched) << steps;
    if (!world.run.is_over()) {
      EXPECT_EQ(world.begin(), Step::kRelease) << steps;
      world.run.done();
    }
    EXPECT_TRUE(world.run.is_over()) << steps;
  }
}

// The command was ended, so that nothing but a new one ends the step.
TEST(DeployHost, StoppingWhileItCleansUpBeginsThatAgain) {
  World world;
  while (!world.run.is_ready()) world.answer(*world.begin());
  world.run.cancel("arm could not be prepared");
  EXPECT_EQ(world.begin(), Step::kRelease);
  world.run.stop();
  EXPECT_EQ(world.begin(), Step::kRelease);
  world.run.done();
  EXPECT_TRUE(world.run.is_over());
  EXPECT_EQ(world.run.reason(), "arm could not be prepared");
  world.run.stop();
  EXPECT_TRUE(world.run.is_over());
}

TEST(DeployHost, StoppingWhileItAppliesTellsTheJobAndWaits) {
  World world;
  while (!world.run.is_ready()) world.answer(*world.begin());
  world.run.go();
  EXPECT_EQ(world.begin(), Step::kApply);
  world.run.stop();
  EXPECT_EQ(world.begin(), Step::kStop);
  world.run.lost(world.now, "cut");
  EXPECT_EQ(world.begin(), Step::kConnect);
  world.run.done();
  EXPECT_EQ(world.begin(), Step::kStop);
  world.run.done();
  EXPECT_EQ(world.begin(), Step::kApply);
  world.run.applied(End::kWentBack, "stopped");
  EXPECT_EQ(world.run.end(), End::kWentBack);
  world.run.cancel("too late");
  EXPECT_EQ(world.run.end(), End::kWentBack);
}

}  // namespace host_run_test
}  // namespace timsctl::deploy

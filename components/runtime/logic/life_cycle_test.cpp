#include "components/runtime/logic/life_cycle.h"

#include <utility>

#include <gtest/gtest.h>

namespace rack {
namespace life_cycle_test {

using namespace std::chrono_literals;
using Step = LifeCycle::Step;
using Kind = LifeCycle::Change::Kind;
using Turned = LifeCycle::Turned;
using By = LifeCycle::By;
using tims::type::kError;
using tims::type::kOk;

constexpr tims::Time kStart = tims::Time(100s);

const tims::Header kOff{.type = tims::type::kOff, .src = tims::Address(0x00020100)};

tims::Header on_request(std::uint8_t seq_nr) {
  return {.type = tims::type::kOn, .seq_nr = seq_nr, .dest = tims::Address(1)};
}

TEST(LifeCycle, IsOffAtFirst) {
  LifeCycle cycle(100ms, 1);
  EXPECT_EQ(cycle.status(), Status::kDisabled);
  EXPECT_EQ(cycle.next(kStart), Step::kWait);
  EXPECT_EQ(cycle.wait_until(), tims::kNever);
}

TEST(LifeCycle, AnswersOnWhenItIsOn) {
  LifeCycle cycle(100ms, 1);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(7), By::kComponent), std::nullopt);
  EXPECT_EQ(cycle.next(kStart), Step::kTurnOn);
  EXPECT_EQ(cycle.status(), Status::kDisabled);
  const auto change = cycle.turned_on(kStart, Turned::kOn);
  EXPECT_EQ(change.kind, Kind::kOn);
  ASSERT_EQ(change.requests.size(), 1U);
  EXPECT_EQ(change.requests[0].seq_nr, 7);
  EXPECT_EQ(change.answer, kOk);
  EXPECT_EQ(cycle.status(), Status::kEnabled);
  EXPECT_EQ(cycle.next(kStart), Step::kLoop);
  EXPECT_TRUE(cycle.looped(kStart, true).requests.empty());
}

TEST(LifeCycle, AnswersASecondOnAtOnce) {
  LifeCycle cycle(100ms, 1);
  (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(2), By::kComponent), kError) << "the first is pending";
  (void)cycle.turned_on(kStart, Turned::kOn);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(3), By::kComponent), kOk);
}

TEST(LifeCycle, TriesAgainAfterTheGivenTime) {
  LifeCycle cycle(100ms, 1);
  (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
  const auto change = cycle.turned_on(kStart, Turned::kFailed);
  EXPECT_EQ(change.kind, Kind::kCannotTurnOn);
  ASSERT_EQ(change.requests.size(), 1U);
  EXPECT_EQ(change.answer, kError);
  EXPECT_EQ(cycle.status(), Status::kError);
  EXPECT_EQ(cycle.wait_until(), kStart + 100ms);
  EXPECT_EQ(cycle.next(kStart + 99ms), Step::kWait);
  EXPECT_EQ(cycle.next(kStart + 100ms), Step::kTurnOn);
  EXPECT_EQ(cycle.turned_on(kStart + 100ms, Turned::kOn).kind, Kind::kOn);
  EXPECT_EQ(cycle.status(), Status::kEnabled);
}

TEST(LifeCycle, NeverTriesAgainWithoutAPause) {
  for (const auto wanted : {0ms, 9ms, 10ms, 11ms}) {
    LifeCycle cycle(wanted, 1);
    cycle.turn_on();
    (void)cycle.turned_on(kStart, Turned::kFailed);
    EXPECT_EQ(cycle.wait_until(), kStart + std::max<tims::Duration>(wanted, 10ms));
    EXPECT_EQ(cycle.next(kStart + 9ms), Step::kWait);
  }
}

TEST(LifeCycle, TriesImmediatelyOnRequest) {
  LifeCycle cycle(1h, 1);
  (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
  (void)cycle.turned_on(kStart, Turned::kFailed);
  EXPECT_EQ(cycle.next(kStart + 1s), Step::kWait);
  EXPECT_EQ(cycle.turn_on(kStart + 1s, on_request(2), By::kComponent), std::nullopt);
  EXPECT_EQ(cycle.next(kStart + 1s), Step::kTurnOn);
  EXPECT_EQ(cycle.turn_on(kStart + 1s, on_request(3), By::kOperator), kError) << "one at a time";
  const auto change = cycle.turned_on(kStart + 2s, Turned::kFailed);
  ASSERT_EQ(change.requests.size(), 1U);
  EXPECT_EQ(change.requests[0].seq_nr, 2);
  EXPECT_EQ(change.answer, kError);
  EXPECT_EQ(cycle.wait_until(), kStart + 2s + 1h);
}

TEST(LifeCycle, OffByHandHoldsUntilOnByHand) {
  LifeCycle cycle(100ms, 1);
  (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
  (void)cycle.turned_on(kStart, Turned::kOn);
  (void)cycle.turn_off(kOff, By::kOperator);
  (void)cycle.turned_off();
  EXPECT_EQ(cycle.held_off_by(), kOff.src);
  EXPECT_EQ(cycle.turn_on(kStart + 2s, on_request(2), By::kComponent), kError);
  EXPECT_EQ(cycle.next(kStart + 2s), Step::kWait);
  (void)cycle.turn_off(on_request(3), By::kComponent);
  EXPECT_EQ(cycle.held_off_by(), kOff.src) << "the first OFF counts";
  EXPECT_EQ(cycle.turn_on(kStart + 4s, on_request(4), By::kOperator), std::nullopt);
  EXPECT_FALSE(cycle.held_off_by());
  EXPECT_EQ(cycle.next(kStart + 4s), Step::kTurnOn);
}

TEST(LifeCycle, OffByAComponentDoesNotHold) {
  LifeCycle cycle(100ms, 1);
  (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
  (void)cycle.turned_on(kStart, Turned::kOn);
  (void)cycle.turn_off(kOff, By::kComponent);
  (void)cycle.turned_off();
  EXPECT_EQ(cycle.turn_on(kStart, on_request(2), By::kComponent), std::nullopt);
}

TEST(LifeCycle, DrawsTheTimeOfTheNextTry) {
  for (std::uint32_t seed = 1; seed < 100; ++seed) {
    LifeCycle cycle(std::nullopt, seed);
    (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
    (void)cycle.turned_on(kStart, Turned::kFailed);
    EXPECT_GE(cycle.wait_until(), kStart + 2s);
    EXPECT_LE(cycle.wait_until(), kStart + 4s);
  }
}

TEST(LifeCycle, GoesOffFromEveryState) {
  LifeCycle on(100ms, 1);
  (void)on.turn_on(kStart, on_request(1), By::kComponent);
  (void)on.turned_on(kStart, Turned::kOn);
  EXPECT_TRUE(on.turn_off(kOff, By::kComponent).empty());
  EXPECT_EQ(on.next(kStart), Step::kTurnOff);
  EXPECT_EQ(on.turned_off().kind, Kind::kOff);
  EXPECT_EQ(on.status(), Status::kDisabled);

  LifeCycle in_error(1h, 1);
  (void)in_error.turn_on(kStart, on_request(1), By::kComponent);
  (void)in_error.turned_on(kStart, Turned::kFailed);
  (void)in_error.turn_off(kOff, By::kComponent);
  EXPECT_EQ(in_error.next(kStart), Step::kTurnOff);
  (void)in_error.turned_off();
  EXPECT_EQ(in_error.status(), Status::kDisabled);
}

TEST(LifeCycle, OffByHandHoldsOverACrash) {
  LifeCycle cycle(100ms, 1);
  cycle.hold_off(tims::Address(0x00020001));
  EXPECT_EQ(cycle.held_off_by(), tims::Address(0x00020001));
  EXPECT_EQ(cycle.turn_on(kStart, on_request(1), By::kComponent), kError);
  EXPECT_EQ(cycle.next(kStart), Step::kWait);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(2), By::kOperator), std::nullopt);
  EXPECT_EQ(cycle.next(kStart), Step::kTurnOn);
}

TEST(LifeCycle, OffEndsAPendingOn) {
  LifeCycle cycle(100ms, 1);
  (void)cycle.turn_on(kStart, on_request(5), By::kComponent);
  const auto unanswered = cycle.turn_off(kOff, By::kComponent);
  ASSERT_EQ(unanswered.size(), 1U);
  EXPECT_EQ(unanswered[0].seq_nr, 5);
  const auto change = cycle.turned_on(kStart, Turned::kOn);
  EXPECT_TRUE(change.requests.empty()) << "it was answered already";
  EXPECT_EQ(cycle.next(kStart), Step::kTurnOff);
}

TEST(LifeCycle, AFailingLoopIsAnErrorOnlyWhileItShouldBeOn) {
  LifeCycle cycle(100ms, 1);
  (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
  (void)cycle.turned_on(kStart, Turned::kOn);
  EXPECT_EQ(cycle.looped(kStart, false).kind, Kind::kError);
  EXPECT_EQ(cycle.status(), Status::kError);
  (void)cycle.turned_on(kStart + 100ms, Turned::kOn);
  (void)cycle.turn_off(kOff, By::kComponent);
  EXPECT_EQ(cycle.looped(kStart + 200ms, false).kind, Kind::kOff);
  EXPECT_EQ(cycle.status(), Status::kDisabled);
}

TEST(LifeCycle, OffIsCarriedOutAlsoIfOnFollowsAtOnce) {
  for (const bool loop_is_good : {true, false}) {
    LifeCycle cycle(100ms, 1);
    (void)cycle.turn_on(kStart, on_request(1), By::kComponent);
    (void)cycle.turned_on(kStart, Turned::kOn);
    (void)cycle.turn_off(kOff, By::kComponent);
    EXPECT_EQ(cycle.turn_on(kStart, on_request(2), By::kComponent), std::nullopt);
    // The loop that was running.
    const auto looped = cycle.looped(kStart, loop_is_good);
    EXPECT_EQ(looped.kind, loop_is_good ? Kind::kNone : Kind::kOff);
    EXPECT_TRUE(looped.requests.empty());
    if (loop_is_good) {
      EXPECT_EQ(cycle.next(kStart), Step::kTurnOff);
      EXPECT_TRUE(cycle.turned_off().requests.empty());
    }
    EXPECT_EQ(cycle.next(kStart), Step::kTurnOn);
    const auto change = cycle.turned_on(kStart, Turned::kOn);
    ASSERT_EQ(change.requests.size(), 1U);
    EXPECT_EQ(change.requests[0].seq_nr, 2);
    EXPECT_EQ(change.answer, kOk);
    EXPECT_EQ(cycle.next(kStart), Step::kLoop);
  }
}

TEST(LifeCycle, RequestsOfOnWaitForTheSameResult) {
  LifeCycle cycle(100ms, 1);
  constexpr bool kWaits = true;
  cycle.turn_on();
  for (std::uint8_t i = 0; i < LifeCycle::kWaitingMax; ++i)
    ASSERT_EQ(cycle.turn_on(kStart, on_request(i), By::kComponent, kWaits), std::nullopt);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(99), By::kComponent, kWaits), kError) << "too many";
  EXPECT_EQ(cycle.turn_on(kStart, on_request(99), By::kComponent), kError) << "of the original";
  EXPECT_EQ(cycle.turned_on(kStart, Turned::kFailed).requests.size(), LifeCycle::kWaitingMax);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(1), By::kComponent, kWaits), std::nullopt);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(2), By::kComponent, kWaits), std::nullopt);
  EXPECT_EQ(cycle.turn_off(kOff, By::kComponent).size(), 2U);
}

TEST(LifeCycle, AMissingPartnerIsWaitedForAtTheStart) {
  LifeCycle cycle(1h, 1);
  cycle.wait_for_partners(kStart + 10s);
  cycle.turn_on();
  EXPECT_EQ(cycle.turn_on(kStart, on_request(1), By::kComponent, true), std::nullopt);
  const auto change = cycle.turned_on(kStart, Turned::kPartnerIsMissing);
  EXPECT_EQ(change.kind, Kind::kWaits);
  EXPECT_TRUE(change.requests.empty()) << "it waits too";
  EXPECT_EQ(cycle.status(), Status::kDisabled);
  EXPECT_EQ(cycle.next(kStart), Step::kWait);
  const tims::Time again = cycle.wait_until();
  EXPECT_LT(again, kStart + 1s);
  EXPECT_EQ(cycle.next(again), Step::kTurnOn);
  EXPECT_EQ(cycle.turned_on(again, Turned::kOn).requests.size(), 1U);
  EXPECT_EQ(cycle.wait_until(), tims::kNever);
}

TEST(LifeCycle, AMissingPartnerIsAnErrorLater) {
  for (const auto& [at, result] :
       {std::pair(10s, Turned::kPartnerIsMissing), std::pair(0s, Turned::kFailed)}) {
    LifeCycle cycle(1h, 1);
    cycle.wait_for_partners(kStart + 10s);
    cycle.turn_on();
    EXPECT_EQ(cycle.turned_on(kStart + at, result).kind, Kind::kCannotTurnOn);
    EXPECT_EQ(cycle.status(), Status::kError);
  }
}

TEST(LifeCycle, AnOperatorGetsTheReasonAtOnce) {
  LifeCycle cycle(1h, 1);
  cycle.wait_for_partners(kStart + 10s);
  EXPECT_EQ(cycle.turn_on(kStart, on_request(1), By::kOperator), std::nullopt);
  const auto change = cycle.turned_on(kStart, Turned::kPartnerIsMissing);
  EXPECT_EQ(change.kind, Kind::kCannotTurnOn);
  EXPECT_EQ(change.answer, kError);
  ASSERT_EQ(change.requests.size(), 1U);
}

TEST(LifeCycle, OffEndsTheWaitForAPartner) {
  LifeCycle cycle(1h, 1);
  cycle.wait_for_partners(kStart + 10s);
  cycle.turn_on();
  (void)cycle.turned_on(kStart, Turned::kPartnerIsMissing);
  EXPECT_TRUE(cycle.turn_off(kOff, By::kComponent).empty());
  EXPECT_EQ(cycle.next(kStart + 1s), Step::kWait);
  EXPECT_EQ(cycle.wait_until(), tims::kNever);
}

}  // namespace life_cycle_test
}  // namespace rack

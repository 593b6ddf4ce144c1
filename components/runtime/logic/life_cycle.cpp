#include "components/runtime/logic/life_cycle.h"

#include <algorithm>
#include <utility>

namespace rack {
namespace {

using tims::type::kError;
using tims::type::kOk;

// A component that fails at once would otherwise use a whole processor, and flood the log.
constexpr tims::Duration kRetryAtLeast = std::chrono::milliseconds(10);
constexpr tims::Duration kLookForPartner = std::chrono::milliseconds(200);
constexpr tims::Duration kRetryShortest = std::chrono::seconds(2);
constexpr tims::Duration kRetryLongest = std::chrono::seconds(4);

}  // namespace

LifeCycle::LifeCycle(std::optional<tims::Duration> error_retry, std::uint32_t seed)
    : random_(seed) {
  if (error_retry) error_retry_ = std::max(*error_retry, kRetryAtLeast);
}

// --- commands

std::optional<std::int8_t> LifeCycle::turn_on(tims::Time now, const tims::Header& request, By by,
                                              bool may_wait) {
  if (by == By::kOperator) held_off_by_.reset();
  if (held_off_by_) return kError;
  if (wants_on_ && state_ == State::kEnabled && !must_turn_off_) return kOk;
  const bool is_pending = !requests_.empty() || (wants_on_ && state_ == State::kDisabled);
  if (is_pending && (!may_wait || requests_.size() >= kWaitingMax)) return kError;
  wants_on_ = true;
  by_operator_ = by_operator_ || by == By::kOperator;
  requests_.push_back(request);
  retry_at_ = now;
  return std::nullopt;
}

std::vector<tims::Header> LifeCycle::turn_off(const tims::Header& request, By by) {
  wants_on_ = false;
  by_operator_ = false;
  must_turn_off_ = state_ == State::kEnabled;
  if (by == By::kOperator) held_off_by_ = request.src;
  return std::exchange(requests_, {});
}

Status LifeCycle::status() const {
  switch (state_) {
    case State::kDisabled:
      return Status::kDisabled;
    case State::kEnabled:
      return Status::kEnabled;
    case State::kErrorWait:
      break;
  }
  return Status::kError;
}

// --- steps

LifeCycle::Step LifeCycle::next(tims::Time now) {
  switch (state_) {
    case State::kDisabled:
      return wants_on_ && now >= retry_at_ ? Step::kTurnOn : Step::kWait;
    case State::kEnabled:
      return wants_on_ && !must_turn_off_ ? Step::kLoop : Step::kTurnOff;
    case State::kErrorWait:
      break;
  }
  if (!wants_on_) return Step::kTurnOff;
  return now >= retry_at_ ? Step::kTurnOn : Step::kWait;
}

tims::Time LifeCycle::wait_until() const {
  const bool tries_again = state_ == State::kErrorWait || (state_ == State::kDisabled && wants_on_);
  return tries_again ? retry_at_ : tims::kNever;
}

LifeCycle::Change LifeCycle::turned_on(tims::Time now, Turned result) {
  const bool waits =
      result == Turned::kPartnerIsMissing && wants_on_ && !by_operator_ && now < partners_until_;
  if (waits) {
    state_ = State::kDisabled;
    retry_at_ = now + kLookForPartner;
    return {.kind = Change::Kind::kWaits};
  }
  if (result != Turned::kOn) {
    fail(now);
    return change(Change::Kind::kCannotTurnOn, kError);
  }
  state_ = State::kEnabled;
  return change(Change::Kind::kOn, kOk);
}

LifeCycle::Change LifeCycle::looped(tims::Time now, bool success) {
  if (must_turn_off_ || (!success && !wants_on_)) return success ? Change{} : turned_off();
  if (success) return change(Change::Kind::kNone, kOk);
  fail(now);
  return change(Change::Kind::kError, kError);
}

LifeCycle::Change LifeCycle::turned_off() {
  state_ = State::kDisabled;
  must_turn_off_ = false;
  return {.kind = Change::Kind::kOff};
}

LifeCycle::Change LifeCycle::change(Change::Kind kind, std::int8_t answer) {
  by_operator_ = false;
  return {.kind = kind, .requests = std::exchange(requests_, {}), .answer = answer};
}

void LifeCycle::fail(tims::Time now) {
  state_ = State::kErrorWait;
  std::uniform_int_distribution<tims::Duration::rep> between(kRetryShortest.count(),
                                                             kRetryLongest.count());
  retry_at_ = now + error_retry_.value_or(tims::Duration(between(random_)));
}

}  // namespace rack

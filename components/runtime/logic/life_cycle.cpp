#include "components/runtime/logic/life_cycle.h"

#include <algorithm>
#include <utility>

namespace rack {
namespace {

using tims::type::kError;
using tims::type::kOk;

// A component that fails at once would otherwise use a whole processor, and flood the log.
constexpr tims::Duration kRetryAtLeast = std::chrono::milliseconds(10);
constexpr tims::Duration kRetryShortest = std::chrono::seconds(2);
constexpr tims::Duration kRetryLongest = std::chrono::seconds(4);

}  // namespace

LifeCycle::LifeCycle(std::optional<tims::Duration> error_retry, std::uint32_t seed)
    : random_(seed) {
  if (error_retry) error_retry_ = std::max(*error_retry, kRetryAtLeast);
}

// --- commands

std::optional<std::int8_t> LifeCycle::turn_on(tims::Time now, const tims::Header& request, By by) {
  if (by == By::kOperator) held_off_by_.reset();
  if (held_off_by_) return kError;
  if (wants_on_ && state_ == State::kEnabled) return kOk;
  if (request_ || (wants_on_ && state_ == State::kDisabled)) return kError;
  wants_on_ = true;
  request_ = request;
  retry_at_ = now;
  return std::nullopt;
}

std::optional<tims::Header> LifeCycle::turn_off(const tims::Header& request, By by) {
  wants_on_ = false;
  if (by == By::kOperator) held_off_by_ = request.src;
  return std::exchange(request_, std::nullopt);
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
      return wants_on_ ? Step::kTurnOn : Step::kWait;
    case State::kEnabled:
      return wants_on_ ? Step::kLoop : Step::kTurnOff;
    case State::kErrorWait:
      break;
  }
  if (!wants_on_) return Step::kTurnOff;
  return now >= retry_at_ ? Step::kTurnOn : Step::kWait;
}

tims::Time LifeCycle::wait_until() const {
  return state_ == State::kErrorWait ? retry_at_ : tims::kNever;
}

LifeCycle::Change LifeCycle::turned_on(tims::Time now, bool success) {
  if (!success) {
    fail(now);
    return change(Change::Kind::kCannotTurnOn, kError);
  }
  state_ = State::kEnabled;
  return change(Change::Kind::kOn, kOk);
}

LifeCycle::Change LifeCycle::looped(tims::Time now, bool success) {
  if (success) return change(Change::Kind::kNone, kOk);
  if (!wants_on_) return turned_off();
  fail(now);
  return change(Change::Kind::kError, kError);
}

LifeCycle::Change LifeCycle::turned_off() {
  state_ = State::kDisabled;
  return {.kind = Change::Kind::kOff};
}

LifeCycle::Change LifeCycle::change(Change::Kind kind, std::int8_t answer) {
  return {.kind = kind, .request = std::exchange(request_, std::nullopt), .answer = answer};
}

void LifeCycle::fail(tims::Time now) {
  state_ = State::kErrorWait;
  std::uniform_int_distribution<tims::Duration::rep> between(kRetryShortest.count(),
                                                             kRetryLongest.count());
  retry_at_ = now + error_retry_.value_or(tims::Duration(between(random_)));
}

}  // namespace rack

// The timer of a request: when its answer is overdue, and how often the request was sent. A
// dialogue repeats a request without answer a limited number of times, then it takes its next step
// or fails.
#pragma once

#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

// Has no clock: times are arguments, from Time{} to kNever. No call fails.
class RetryTimer {
 public:
  // A new request follows, or none: it was not sent yet, and nothing is due.
  void reset() { *this = {}; }
  // Nothing is due; the number of attempts stays.
  void stop() { due_ = tims::kNever; }
  // The request was sent (again). Its answer is overdue after `answer_time`: 0 or more; kForever:
  // never.
  void sent(Time now, Duration answer_time) {
    ++attempts_;
    due_ = answer_time < tims::kNever - now ? now + answer_time : tims::kNever;
  }
  // Replaces the time, without counting an attempt: for a pause, the next part of an answer, or a
  // device that sends without a request.
  void wait_until(Time due) { due_ = due; }
  // Returns true once at or after the time.
  bool take_due(Time now) {
    if (due_ > now) return false;
    stop();
    return true;
  }

  [[nodiscard]] Time due() const { return due_; }  // kNever: nothing is due
  [[nodiscard]] int attempts() const { return attempts_; }
  // `attempts_max`: how often the request is sent in all.
  [[nodiscard]] bool may_repeat(int attempts_max) const { return attempts_ < attempts_max; }

 private:
  int attempts_ = 0;
  Time due_ = tims::kNever;
};

}  // namespace rack::device

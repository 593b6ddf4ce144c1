// Renews the certificate of this router when that is due: asks the authority in a thread of its
// own, since an answer may take seconds. A failure stops nothing: it is logged once a day, and
// tried again each hour.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <thread>

#include "router/io/log.h"
#include "router/io/loop.h"
#include "security/keys/identity.h"
#include "tims/result.h"

namespace tims::io {

class Renewal {
 public:
  static constexpr Duration kTryEvery = std::chrono::hours(1);
  static constexpr Duration kLogEvery = std::chrono::hours(24);
  // For one attempt, which also delays the end of the router.
  static constexpr Duration kPatience = std::chrono::seconds(15);

  struct Steps {
    std::function<bool()> is_due;
    // What is done until the deadline, prepared in the loop's thread and called in another one.
    std::function<std::function<Result<security::Identity>(Time deadline)>()> prepare;
  };
  // `first`: when it looks for the first time; others of the fleet should do it at other times.
  Renewal(Loop& loop, Log& log, Steps steps, Time first)
      : loop_(loop), log_(log), steps_(std::move(steps)), next_(first) {}

  // It may have become due: looks at this time, unless it will look before.
  void look_at(Time time) { next_ = std::min(next_, time); }

  [[nodiscard]] Time next_timeout() const { return next_; }
  void on_timeout(Time now);

 private:
  // `began`: the attempt.
  void on_result(Time began, const Result<security::Identity>& renewed);

  Loop& loop_;
  Log& log_;
  Steps steps_;
  Time next_;
  Time next_log_{};
  bool runs_ = false;
  std::jthread thread_;  // the last member: it uses the others
};

}  // namespace tims::io

// When a program that has ended starts again: soon at first, then less and less often. Pure.
#pragma once

#include <optional>

#include "tims/time.h"
#include "tools/timsctl/robot/robot.h"

namespace timsctl::robot {

inline constexpr tims::Duration kFirstPause = std::chrono::milliseconds(200);
inline constexpr tims::Duration kLongestPause = std::chrono::seconds(10);
// Who has run for so long begins with the first pause.
inline constexpr tims::Duration kProven = std::chrono::seconds(10);
inline constexpr int kUsage = 2;  // exit status: nothing but another command line mends that

class RestartPolicy {
 public:
  explicit RestartPolicy(Restart when) : when_(when) {}

  // It ended with this exit status (128 and more: by a signal) after running for `ran`. How long to
  // wait until it starts again; nothing: it stays down.
  std::optional<tims::Duration> ended(int status, tims::Duration ran);

 private:
  Restart when_;
  tims::Duration pause_ = kFirstPause;
};

}  // namespace timsctl::robot

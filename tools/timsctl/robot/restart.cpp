#include "tools/timsctl/robot/restart.h"

#include <algorithm>

namespace timsctl::robot {

std::optional<tims::Duration> RestartPolicy::ended(int status, tims::Duration ran) {
  if (when_ == Restart::kNever || status == kUsage) return std::nullopt;
  if (when_ == Restart::kOnFailure && status == 0) return std::nullopt;
  if (ran >= kProven) pause_ = kFirstPause;
  const tims::Duration pause = pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
  return pause;
}

}  // namespace timsctl::robot

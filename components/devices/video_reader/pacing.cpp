#include "components/devices/video_reader/pacing.h"

#include <algorithm>
#include <cmath>

namespace rack::device {

Time Pacing::due(Time now, Duration media) {
  if (speed_ == 0) return now;
  if (!last_due_) {
    last_media_ = media;
    last_due_ = now;
    return now;
  }
  const Duration gap = std::clamp(media - last_media_, Duration(0), kGapMax);
  last_media_ = media;
  const double scaled = static_cast<double>(gap.count()) / speed_;
  // A year, so that the sum cannot overflow.
  const Duration after(std::llround(std::min(scaled, 3.15e16)));
  *last_due_ += after;
  if (*last_due_ < now - kLateMax) last_due_ = now;
  return *last_due_;
}

}  // namespace rack::device

// When the frames of a file are due: at their own rate, or faster or slower. Pure.
#pragma once

#include <optional>

#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

class Pacing {
 public:
  // speed: a factor; 0: each frame is due at once.
  explicit Pacing(double speed) : speed_(speed) {}

  // `media`: time of the frame since the beginning of the file. Frames that are late by up to
  // kLateMax are due in the past, so that the rate is kept on average; after a longer pause of the
  // reader the times go on from now.
  Time due(Time now, Duration media);

  static constexpr Duration kLateMax = std::chrono::seconds(2);
  // A longer gap between two frames is an error of the file's times.
  static constexpr Duration kGapMax = std::chrono::seconds(10);

 private:
  double speed_;
  std::optional<Time> last_due_;
  Duration last_media_{};
};

}  // namespace rack::device

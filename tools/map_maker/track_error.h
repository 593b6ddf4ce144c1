// How far a track that was made from a log is from the truth. Pure.
//
// With relations (Kuemmerle et al. 2009): for each, how the step between its two scans differs from
// the one that was measured. With poses: the track is laid on them as a whole first (the rigid
// motion of least squares), as nobody told the map maker where north is.
#pragma once

#include <span>
#include <vector>

#include "tools/mcl_eval/truth.h"

namespace rack::map_maker {

struct TrackError {
  std::vector<double> metres{};
  std::vector<double> degrees{};
};

// `laser`: of each scan of the log.
TrackError track_error(std::span<const Pose> laser, const mcl_eval::Truth& truth);

}  // namespace rack::map_maker

// The heading of a robot whose place is roughly known, for example by the first fix of satellites.
// Pure.
//
// A receiver at rest has no course, and a particle filter that starts with all headings may settle
// at a wrong one: at rest it gets one scan only, since repeated ones measure the same. So the scan
// is compared with the map from places around the known one, in all directions. The pose that fits
// best is the answer if it fits well, and if no pose with another heading fits nearly as well.
#pragma once

#include <optional>
#include <span>

#include "components/localisation/likelihood_field.h"

namespace rack::localisation {

struct HeadingSearch {
  Pose pose{};           // that fits best
  double fit = 0;        // 0 to 1
  double rival_fit = 0;  // of the best pose with another heading

  // Whether this is the pose, and not one of several.
  [[nodiscard]] bool is_clear() const;
};

// `deviation`: of the known place, mm. Empty: the scan has no points.
std::optional<HeadingSearch> find_heading(const LikelihoodField& field,
                                          std::span<const BeamEnd> scan, const Pose& place,
                                          double deviation);

}  // namespace rack::localisation

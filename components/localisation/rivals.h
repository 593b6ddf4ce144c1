// Poses of a map that look like the one where the localiser has settled. Pure.
//
// Rooms repeat, and some buildings look the same after half a turn. A particle filter that has
// found its place in the whole map keeps only one of such poses: sooner or later, resampling drops
// the others by chance. So they are kept here. When the cloud has settled, the whole map is
// searched once for other poses from which the scan fits nearly as well. Each of these rivals moves
// with the odometry and climbs to where the next scan fits best. The evidence for it changes with
// each scan by the difference between its fit and that of the settled pose, as the weights of the
// filter do (beams through walls count against a pose), and is forgotten slowly, so that the noise
// of fits does not add up to a decision. A rival with strong evidence against it is dropped; one
// with strong evidence for it takes over. As long as there are rivals, the pose is unknown.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/localisation/likelihood_field.h"
#include "components/localisation/particle_filter.h"

namespace rack::localisation {

class Rivals {
 public:
  static constexpr std::size_t kMost = 16;

  // `sharpness`: that of the filter. Allocates all memory.
  explicit Rivals(double sharpness);

  void clear() { rivals_.clear(); }
  // Replaces the rivals by those that this scan does not exclude.
  void search(const LikelihoodField& field, const Beams& beams, const Pose& settled,
              Random& random);
  // A step in the frame of the robot, and the scan after it. The pose of a rival that takes over;
  // the settled one then is its rival.
  std::optional<Pose> take(const LikelihoodField& field, const Beams& beams, const Pose& step,
                           const Pose& settled);
  // Adds the rivals to the covariance of the settled pose, and takes their share.
  void widen(Estimate& estimate) const;

 private:
  struct Rival {
    Pose pose;
    double evidence = 0;  // logarithm of the likelihood ratio
  };
  struct Draw {
    std::uint32_t sum = 0;
    float x = 0;
    float y = 0;
    float rho = 0;
  };

  void draw(const LikelihoodField& field, const Beams& beams, Random& random);
  [[nodiscard]] bool is_known(const Pose& pose, const Pose& settled) const;

  double sharpness_;
  std::vector<Rival> rivals_;
  std::vector<Draw> best_;  // a heap whose front is the worst
};

}  // namespace rack::localisation

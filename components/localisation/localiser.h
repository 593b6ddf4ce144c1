// From odometry and scans to a pose in a map: when the particle filter is fed, with which beams,
// and what is said between its steps. Pure.
//
// A scan is taken when the robot has moved a little since the last one: standing still it would say
// the same thing again and again, and the filter would believe it more than it deserves; but a scan
// that does not fit is always taken, as odometry can stand still while the robot does not. Of a
// scan some beams are taken, evenly spread, others each time. Between two such scans the pose goes
// on as the odometry says. The odometry must be that of the time of the scan: a tenth of a second
// beside it costs a degree while turning.
//
// Where it has settled it stays for a dozen scans when another place has more of the cloud, and a
// fifth of the cloud is kept there meanwhile: people who stand around a robot are on no map, and
// for some scans another place of the building looks more like it than its own. When they have
// gone, that tells the two apart; who was carried away is found that much later.
//
// And it searches elsewhere only when it cannot be where it has settled: when beams would have gone
// through walls from there, or when scans have not fitted for 2 m of its way, along which nobody
// stands before it for long. A robot that waits for people would search in each of its scans else,
// and find, sooner or later, a place that fits by chance.
//
// With the walls of the map the scan is laid on them at last (`scan_matcher.h`), and that is the
// pose that is told; the cloud stays as it is.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/localisation/particle_filter.h"
#include "components/localisation/scan_matcher.h"

namespace rack::localisation {

struct LocaliserSettings {
  FilterSettings filter{};
  std::uint32_t beams = 60;
  double way_between = 100;   // mm between scans that are taken
  double turn_between = 0.1;  // rad
};

class Localiser {
 public:
  Localiser(const LocaliserSettings& settings, std::uint64_t seed);

  void start_at(const Pose& pose, double deviation, double deviation_rho);
  // Wherever it is: found by the next scans.
  void start_anywhere();

  // `odometry`: its pose when the scan was made; `scan`: in the frame of the robot. True: the
  // filter took it. `walls` of the same map: the scan is laid on them; nullptr: it is not.
  bool take(const LikelihoodField& field, const Pose& odometry, std::span<const BeamEnd> scan,
            const WallLines* walls = nullptr);

  // Where the robot was at the last scan, taken or not.
  [[nodiscard]] Pose pose() const { return estimate_.pose + (odometry_ - taken_); }
  // The same with its covariance: what the odometry may have erred since then is in it.
  [[nodiscard]] Estimate now() const;
  // As of the last scan that was taken.
  [[nodiscard]] const Estimate& estimate() const { return estimate_; }
  [[nodiscard]] const ParticleFilter& filter() const { return filter_; }
  [[nodiscard]] const Beams& beams() const { return beams_; }

 private:
  void choose(std::span<const BeamEnd> scan);
  [[nodiscard]] Estimate estimate_from(const Pose& expected);
  [[nodiscard]] bool has_to_search(const LikelihoodField& field, bool moved);

  LocaliserSettings settings_;
  ParticleFilter filter_;
  Random random_;
  ScanMatcher matcher_;
  Beams beams_;
  Estimate estimate_{};
  Pose odometry_{};  // newest
  Pose taken_{};     // and of the last scan taken
  bool anywhere_ = false;
  bool first_ = true;
  bool settled_ = false;      // most of the cloud was in one place
  std::uint32_t doubts_ = 0;  // scans since most of it is elsewhere
  std::uint32_t hidden_ = 0;  // scans on its way that people may stand in
};

}  // namespace rack::localisation

// From odometry and scans to a pose in a map: decides which scans and beams the particle filter
// gets, and gives the pose between two steps of the filter. Pure.
//
// A scan is used when the robot has moved a little since the last one used: at rest, scans repeat
// the same measurement, and the filter would become overconfident. A scan that does not fit is
// always used, since odometry can stand still while the robot does not; but while it stands still,
// the filter looks for a jump nearby only if beams would pass through walls from where the robot
// is. If they only end too early, people stand around it. Some beams of a scan are used, evenly
// spread, other ones each time. Between two such scans the pose follows the odometry.
// The odometry must be that of the time of the scan: an error of 0.1 s costs a degree while
// turning.
//
// Once settled, the estimate stays for a dozen scans when most of the cloud is at another place,
// and a fifth of the cloud is kept at the settled place during that time. People around a robot are
// not in the map, and for some scans another place may look more like the map. When they have gone,
// the scans resolve the ambiguity. A robot that was carried away is found later by that delay.
//
// Once settled, the filter searches elsewhere only when the robot cannot be where it has settled:
// beams would have passed through walls from there, or scans have not fitted for 2 m of travel,
// along which nobody walks in front of it for that long. Otherwise a robot that waits for people
// would search with each scan, and sooner or later find a place that fits by chance.
//
// A place that was found in the whole map may have rivals that look like it (`rivals.h`): then the
// covariance covers them until scans have decided.
//
// With the walls of the map, the scan is finally matched against them (`scan_matcher.h`), and that
// pose is the result; the cloud is not changed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "components/localisation/particle_filter.h"
#include "components/localisation/rivals.h"
#include "components/localisation/scan_matcher.h"

namespace rack::localisation {

struct LocaliserSettings {
  FilterSettings filter{};
  std::uint32_t beams = 60;
  double distance_between = 100;  // mm between scans that are used
  double turn_between = 0.1;      // rad
};

class Localiser {
 public:
  Localiser(const LocaliserSettings& settings, std::uint64_t seed);

  void start_at(const Pose& pose, double deviation, double deviation_rho);
  // The pose is unknown; the next scans find it.
  void start_anywhere();

  // `odometry`: its pose at the time of the scan; `scan`: in the frame of the robot. `walls`: of
  // the same map; the scan is matched against them; nullptr: it is not. Returns whether the filter
  // used the scan.
  bool take(const LikelihoodField& field, const Pose& odometry, std::span<const BeamEnd> scan,
            const WallLines* walls = nullptr);

  // The pose of the robot at the last scan, used or not.
  [[nodiscard]] Pose pose() const { return estimate_.pose + (odometry_ - taken_); }
  // The same with its covariance, which includes the odometry error since the last scan used.
  [[nodiscard]] Estimate now() const;
  // The estimate at the last scan that was used.
  [[nodiscard]] const Estimate& estimate() const { return estimate_; }
  [[nodiscard]] const ParticleFilter& filter() const { return filter_; }
  [[nodiscard]] const Beams& beams() const { return beams_; }

 private:
  void choose(std::span<const BeamEnd> scan);
  [[nodiscard]] Estimate estimate_from(const LikelihoodField& field, const Pose& expected);
  std::optional<Pose> compare_rivals(const LikelihoodField& field, const Pose& step);
  void go_on_at(const Pose& pose);
  [[nodiscard]] bool is_worth_it_at_rest(const LikelihoodField& field) const;
  [[nodiscard]] bool has_to_search(const LikelihoodField& field, bool moved);

  LocaliserSettings settings_;
  ParticleFilter filter_;
  Rivals rivals_;
  Random random_;
  ScanMatcher matcher_;
  Beams beams_;
  Estimate estimate_{};
  Pose odometry_{};  // newest
  Pose taken_{};     // odometry at the last scan used
  bool anywhere_ = false;
  bool first_ = true;
  bool found_ = false;         // in the whole map, so that it may have rivals
  bool settled_ = false;       // kSettled of the weight was in one place
  bool settles_ = false;       // with the present scan
  std::uint32_t at_rest_ = 0;  // scans used since the robot moved
  std::uint32_t doubts_ = 0;   // scans since most of the weight is elsewhere
  std::uint32_t hidden_ = 0;   // scans while moving that did not fit, maybe because of people
};

}  // namespace rack::localisation

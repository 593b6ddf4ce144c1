#include "components/mapping/keyframes.h"

#include <cmath>

#include <Eigen/LU>

#include "components/mapping/scan_search.h"

namespace rack::mapping {

namespace {

constexpr double kDistanceBetween = 200;  // mm
constexpr double kTurnBetween = radians(9);
constexpr double kMapDistance = 5000;     // mm of travel before a scan that it is matched with
constexpr std::size_t kMapScansMax = 40;  // limit for a robot that turns at rest
constexpr std::size_t kPointsLeast = 20;  // of a scan
constexpr double kShareGood = 0.7;        // share of points with a line
constexpr double kKeyframesShareLeast = 0.4;
constexpr Window kJump{.distance = 700, .turn = radians(25)};
constexpr double kKeyframesScoreLeast = 0.3;
constexpr double kOdometryCounts = 0.1;
// Points that must determine a direction. Three people near the robot are 10 to 20 points, of which
// a few determine the direction in which they walk.
constexpr double kFollowPointsLeast = 10;
constexpr double kFollowPointsLeastAgain = 5;

}  // namespace

// The values of the particle filter (FilterSettings), which were found with the same kind of
// robots. But a scanner mounted half a degree off, or a worn wheel, causes the same error in each
// step; the map would bend to compensate. So the odometry counts for a tenth.
Information odometry_information(const Pose& step) {
  const double distance = std::hypot(step.x, step.y);
  const double turn = std::abs(signed_angle(step.rho));
  const double along = 8 + 0.1 * distance;
  const double across = 8 + 0.02 * distance + 0.5 * distance * 0.15 * turn;
  const double turned = 0.003 + 0.15 * turn + 0.05 * distance / 1000;
  const double direction = distance > 0 ? std::atan2(step.y, step.x) : 0;
  Eigen::Matrix3d to_direction;
  to_direction << std::cos(direction), std::sin(direction), 0, -std::sin(direction),
      std::cos(direction), 0, 0, 0, 1;
  const Eigen::Vector3d squares(1 / (along * along), 1 / (across * across), 1 / (turned * turned));
  return kOdometryCounts * to_direction.transpose() * squares.asDiagonal() * to_direction;
}

std::vector<ScanPoint2d> points_around(const Track& track, std::size_t first, std::size_t last,
                                       const Pose& frame) {
  std::vector<ScanPoint2d> points;
  for (std::size_t i = first; i <= last; ++i)
    add_points(track.keyframes[i].points, track.poses[i] - frame, points);
  return points;
}

namespace {

class Follower {
 public:
  explicit Follower(double points_least) : settings_{.least_information = points_least} {}

  void take(const Drive& drive, std::size_t scan) {
    const DriveScan& now = drive.scans[scan];
    if (!std::isfinite(now.odometry.x) || !std::isfinite(now.odometry.y) ||
        !std::isfinite(now.odometry.rho))
      return;
    if (!track_.keyframes.empty()) {
      const Pose step = now.odometry - track_.keyframes.back().odometry;
      if (std::hypot(step.x, step.y) < kDistanceBetween &&
          std::abs(signed_angle(step.rho)) < kTurnBetween)
        return;
    }
    auto points = points_of(drive.beams(now), now.scanner);
    if (points.size() < kPointsLeast) return;
    add({.scan = scan,
         .odometry = now.odometry,
         .points = std::move(points),
         .view = View(drive.beams(now), now.scanner)});
  }
  void add(Keyframe keyframe) {
    keyframe.placed = Placed::kByScans;
    keyframe.travelled = 0;
    if (track_.keyframes.empty()) {
      track_.poses.push_back(keyframe.odometry);
      track_.keyframes.push_back(std::move(keyframe));
      return;
    }
    const Pose step = keyframe.odometry - track_.keyframes.back().odometry;
    const std::size_t last = track_.keyframes.size() - 1;
    const Information odometry = odometry_information(step);
    const std::size_t searched = track_.searched;
    const auto found = find(keyframe, {step, odometry});
    if (track_.searched > searched) keyframe.placed = Placed::kBySearch;
    if (!found) keyframe.placed = Placed::kByOdometry;
    const Pose went = found ? found->pose : step;
    if (found) track_.edges.push_back({last, last + 1, found->pose, found->information});
    if (!found) ++track_.unmatched;
    track_.edges.push_back({last, last + 1, step, odometry});
    keyframe.travelled = track_.keyframes.back().travelled + std::hypot(went.x, went.y);
    track_.poses.push_back(track_.poses.back() + went);
    track_.keyframes.push_back(std::move(keyframe));
  }

  Track take_track() { return std::move(track_); }

 private:
  // The pose relative to the last keyframe.
  std::optional<Match> find(const Keyframe& keyframe, const Prior& prior) {
    const auto& keyframes = track_.keyframes;
    const std::size_t last = keyframes.size() - 1;
    std::size_t first = last;
    while (first > 0 && keyframes[last].travelled - keyframes[first - 1].travelled < kMapDistance &&
           last - first < kMapScansMax)
      --first;
    const auto map = points_around(track_, first, last, track_.poses[last]);
    const PointIndex index(map);
    auto best = match(index, keyframe.points, prior.pose, prior, settings_);
    if (best && best->share >= kShareGood) return best;
    const auto jumped =
        ScanSearch(map).find(keyframe.points, prior.pose, kJump, kKeyframesScoreLeast);
    if (jumped) {
      const auto other = match(index, keyframe.points, jumped->pose, {}, settings_);
      if (other && (!best || other->share > best->share + 0.05)) {
        best = other;
        ++track_.searched;
      }
    }
    return best && best->share >= kKeyframesShareLeast ? best : std::nullopt;
  }

  localisation::MatchSettings settings_;
  Track track_;
};

}  // namespace

std::optional<Track> follow(const Drive& drive, const Progress& progress) {
  Follower follower(kFollowPointsLeast);
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (i % 64 == 0 && !progress("matching the scans", i, drive.scans.size())) return std::nullopt;
    follower.take(drive, i);
  }
  return follower.take_track();
}

std::optional<Track> follow_again(Track track, const Progress& progress) {
  Follower follower(kFollowPointsLeastAgain);
  for (std::size_t i = 0; i < track.keyframes.size(); ++i) {
    if (i % 64 == 0 && !progress("matching the scans again", i, track.keyframes.size()))
      return std::nullopt;
    follower.add(std::move(track.keyframes[i]));
  }
  return follower.take_track();
}

}  // namespace rack::mapping

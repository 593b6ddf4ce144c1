// Replays a log: the localiser receives the odometry and the scans, and its estimates are compared
// with the ground truth. Pure except for the stopwatch argument. The localiser is ours or another
// filter for comparison.
//
// Tracking starts with an error of half a metre and 15 degrees. Relations contain no start pose; it
// is first estimated by a global start on the same log, and tracking starts there. The first true
// pose is not compared, because the start depends on it. After a global start, estimates count from
// the first one with an error below one metre and 20 degrees.
//
// Optional disturbances: errors of the odometry, shortened beams (people), and a kidnapped robot:
// the drive continues at another place, at least 10 m away, without a change of the odometry.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "components/localisation/localiser.h"
#include "tools/evaluation/mcl_eval/truth.h"

namespace rack::mcl_eval {

// Indices of the scans at which the robot is carried away and at which the drive continues.
struct Kidnapping {
  std::size_t leave = 0;
  std::size_t arrive = 0;
};

struct Trial {
  localisation::LocaliserSettings settings{};
  const localisation::WallLines* walls = nullptr;  // for scan matching; nullptr: none
  std::uint64_t seed = 1;
  double lag = 0;  // age of scans at their time stamps, s
  bool global = false;
  std::optional<Kidnapping> kidnap{};
  double odometry_scale = 1;  // factor of distances
  double odometry_drift = 0;  // deg/m
  double short_beams = 0;     // fraction of shortened beams
  bool keep_poses = false;
  std::size_t begin = 0;  // index of the true pose at which the drive starts
  // The drive ends after this distance, m; counted from the kidnapping if there is one.
  double distance_max = std::numeric_limits<double>::infinity();
};

// Poses of the robot at one scan. The odometry starts at the true pose, or at the estimate without
// ground truth.
struct PoseRow {
  double time = 0;  // time in the log, s
  Pose estimate{};
  Pose odometry{};
  std::optional<Pose> truth{};
};

struct Outcome {
  std::vector<double> metres{};  // errors
  std::vector<double> degrees{};
  double share_over_1m = 0;               // fraction of the true poses
  bool lost = false;                      // more than 1 m or 20 degrees off at the end
  std::optional<double> found_after{};    // distance driven since a global start, m
  std::optional<double> refound_after{};  // distance driven since the kidnapping, m
  std::size_t updates = 0;
  std::size_t recoveries = 0;  // updates in which particles were drawn from the whole map
  double us_per_update = 0;
  std::vector<PoseRow> poses{};  // of all scans, if keep_poses is set
};

// As CSV with named columns: trajectories, and errors where there is ground truth.
std::string to_csv(std::span<const PoseRow> poses);

// A kidnapping in the middle of the log. Empty if no two true poses are 10 m apart.
std::optional<Kidnapping> kidnapping(const Truth& truth);

// A kidnapping between random poses that are at least 10 m apart, after 30 m of driving and with 20
// m left.
struct Journey {
  std::size_t begin = 0;  // index of the first true pose
  Kidnapping kidnapping{};
};
std::vector<Journey> journeys(const Truth& truth, std::size_t count, std::uint64_t seed);

using Stopwatch = std::function<double()>;  // us

// The interface of the evaluated localiser; same meaning as in Localiser.
class Contestant {
 public:
  virtual ~Contestant() = default;
  virtual void start_at(const Pose& pose, double deviation, double deviation_rho) = 0;
  virtual void start_anywhere() = 0;
  // `beams`: in the frame of the robot; `scan` contains the pose of the scanner on the robot.
  virtual bool take(const Pose& odometry, const localisation::LogScan& scan,
                    std::span<const localisation::BeamEnd> beams) = 0;
  [[nodiscard]] virtual Pose pose() const = 0;
  [[nodiscard]] virtual double share() const = 0;   // fraction of the weight in the main cluster
  [[nodiscard]] virtual bool searches() const = 0;  // particles were drawn from the whole map
};

Outcome run(const Trial& trial, const localisation::CarmenLog& log,
            const localisation::LikelihoodField& field, const Truth& truth,
            const Stopwatch& stopwatch);
// Evaluates another localiser instead of ours; `field` is used to find the start for relations.
Outcome run(const Trial& trial, const localisation::CarmenLog& log,
            const localisation::LikelihoodField& field, const Truth& truth,
            const Stopwatch& stopwatch, Contestant& contestant);

using tims::base::mean;
using tims::base::quantile;

}  // namespace rack::mcl_eval

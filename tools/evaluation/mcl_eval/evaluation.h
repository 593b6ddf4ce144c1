// A drive through a log: the localiser is given what the robot had, and what it says is compared
// with the truth. Pure but for the stopwatch that is handed in. Who localises is ours, or somebody
// else's filter that is to stand beside it.
//
// Tracking starts beside the truth: half a metre and 15 degrees off. With relations there is no
// such place; it is found first, by a global start on the same log, and tracking then starts from
// there. The first true pose is not compared: it was given away. A global start knows nothing; what
// it says counts from where it first was within a metre and 20 degrees.
//
// What makes it harder: odometry that is wrong, beams that people cut short, and the robot carried
// away: it goes on where the robot was at least 10 m away, while the odometry stands still.
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

// Where it is carried away and where it goes on, of the log's scans.
struct Kidnapping {
  std::size_t leave = 0;
  std::size_t arrive = 0;
};

struct Trial {
  localisation::LocaliserSettings settings{};
  const localisation::WallLines* walls = nullptr;  // that scans are laid on, if they are
  std::uint64_t seed = 1;
  double lag = 0;  // s: scans are older than their time
  bool global = false;
  std::optional<Kidnapping> kidnap{};
  double odometry_scale = 1;  // of ways
  double odometry_drift = 0;  // deg/m
  double short_beams = 0;     // share
  bool keep_poses = false;
  std::size_t begin = 0;  // of the truth's poses: where the drive begins
  // m driven, since it was carried away if it is: there the drive ends.
  double way_max = std::numeric_limits<double>::infinity();
};

// At one scan, of the robot; the odometry begins where the truth does, or else the estimate.
struct PoseRow {
  double time = 0;  // s, of the log
  Pose estimate{};
  Pose odometry{};
  std::optional<Pose> truth{};
};

struct Outcome {
  std::vector<double> metres{};  // errors
  std::vector<double> degrees{};
  double share_over_1m = 0;               // of the truth's poses
  bool lost = false;                      // more than 1 m or 20 degrees off at the end
  std::optional<double> found_after{};    // m driven since a global start
  std::optional<double> refound_after{};  // since it was carried away
  std::size_t updates = 0;
  std::size_t recoveries = 0;  // updates in which particles were drawn anew
  double us_per_update = 0;
  std::vector<PoseRow> poses{};  // of all scans, if they are wanted
};

// As columns with names between commas: tracks, and errors where there is a truth.
std::string to_csv(std::span<const PoseRow> poses);

// From the middle of the truth on; nothing: it has no two poses that are 10 m apart.
std::optional<Kidnapping> kidnapping(const Truth& truth);

// A drive from anywhere to anywhere else, at least 10 m away: it has gone on for 30 m before, and
// 20 m are left.
struct Journey {
  std::size_t begin = 0;  // of the truth's poses
  Kidnapping kidnapping{};
};
std::vector<Journey> journeys(const Truth& truth, std::size_t count, std::uint64_t seed);

using Stopwatch = std::function<double()>;  // us

// Who is judged. All as Localiser has it.
class Contestant {
 public:
  virtual ~Contestant() = default;
  virtual void start_at(const Pose& pose, double deviation, double deviation_rho) = 0;
  virtual void start_anywhere() = 0;
  // `beams` in the frame of the robot; `scan` says where on it the scanner is and looks.
  virtual bool take(const Pose& odometry, const localisation::LogScan& scan,
                    std::span<const localisation::BeamEnd> beams) = 0;
  [[nodiscard]] virtual Pose pose() const = 0;
  [[nodiscard]] virtual double share() const = 0;   // of the cloud, in one place
  [[nodiscard]] virtual bool searches() const = 0;  // particles were drawn anew
};

Outcome run(const Trial& trial, const localisation::CarmenLog& log,
            const localisation::LikelihoodField& field, const Truth& truth,
            const Stopwatch& stopwatch);
// Somebody else in the place of our localiser; `field` finds where relations begin.
Outcome run(const Trial& trial, const localisation::CarmenLog& log,
            const localisation::LikelihoodField& field, const Truth& truth,
            const Stopwatch& stopwatch, Contestant& contestant);

using tims::base::mean;
using tims::base::quantile;

}  // namespace rack::mcl_eval

// Evaluation of object tracking. With simulated people: MOTA (Bernardin, Stiefelhagen: the CLEAR
// MOT metrics, 2008), which counts missed people, false positives and identity switches, and errors
// of position and velocity. On a recorded drive: a list of all objects reported as moving, for
// manual inspection. Pure except for the stopwatch argument.
//
// A person counts in a scan if at least two beams hit it. An object is assigned to a person within
// half a metre; the assignment of the previous scan has priority. An object next to a hidden person
// is neither a match nor a false positive.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "components/localisation/carmen_log.h"
#include "components/perception/object_recogniser.h"
#include "tools/evaluation/track_eval/people.h"

namespace rack::track_eval {

using Stopwatch = std::function<double()>;  // us

struct Score {
  std::uint64_t people = 0;  // visible people, summed over all scans
  std::uint64_t missed = 0;
  std::uint64_t wrong = 0;      // false positives
  std::uint64_t switches = 0;   // identity switches
  std::vector<double> off{};    // position errors, mm
  std::vector<double> speed{};  // errors of the velocity vector, mm/s
  std::uint32_t ghosts = 0;     // moving objects without a person, counted by identity
  double minutes = 0;
  double us_per_scan = 0;

  [[nodiscard]] double mota() const;
};

// `map`: of the hall, or nullptr.
Score follow_people(const HallSettings& settings, double seconds,
                    const localisation::LikelihoodField* map, const Stopwatch& stopwatch);

// --- a recorded drive

struct Mover {
  std::int32_t id = 0;
  double from = 0;  // s since the start of the log
  double to = 0;
  double distance = 0;  // mm, largest distance from the first position reported as moving
  double speed = 0;     // mm/s, mean
  double size = 0;      // mm
  MapPoint first{};     // positions in the frame of the map or the odometry
  MapPoint last{};
  double on_map = 0;  // fraction of its positions on occupied cells of the map, if any
  perception::ObjectKind kind{};
};

struct DriveScore {
  std::vector<Mover> movers{};
  std::size_t scans = 0;
  std::size_t objects = 0;  // confirmed objects, summed over all scans
  double minutes = 0;       // processed time
  double us_per_scan = 0;
};

// The estimated times of the scans, s. Some logging programs write several scans at once, with
// nearly the same time stamp. If a log has such bunches, the time of a scan is the mean over its
// neighbours on both sides (between pauses), else the time stamp of the log.
std::vector<double> even_times(const std::vector<localisation::LogScan>& scans);

struct DriveSettings {
  double lag = 0;                                      // age of scans at their time stamps, s
  const localisation::LikelihoodField* map = nullptr;  // map for localisation
  bool subtract = true;  // remove points of the map; false: only compute on_map
  std::uint64_t seed = 1;
};

DriveScore follow_drive(const localisation::CarmenLog& log, const DriveSettings& settings,
                        const Stopwatch& stopwatch);

}  // namespace rack::track_eval

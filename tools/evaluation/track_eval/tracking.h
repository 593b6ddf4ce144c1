// How well objects are followed. With people whose truth is known: MOTA (Bernardin, Stiefelhagen:
// the CLEAR MOT metrics, 2008), which counts people that were missed, objects where nobody is, and
// numbers that changed, and errors of place and speed. On a recorded drive: every object that was
// said to move, with its way, for somebody to look at. Pure but for the stopwatch handed in.
//
// A person counts in a scan as soon as two beams have met it. An object belongs to a person within
// half a metre, last time's first. What stands beside a person that is hidden is neither right nor
// wrong.
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
  std::uint64_t people = 0;  // in all scans
  std::uint64_t missed = 0;
  std::uint64_t wrong = 0;      // objects where nobody is
  std::uint64_t switches = 0;   // of numbers
  std::vector<double> off{};    // mm
  std::vector<double> speed{};  // mm/s, error of the speed as a vector
  std::uint32_t ghosts = 0;     // objects that move where nobody is, by their numbers
  double minutes = 0;
  double us_per_scan = 0;

  [[nodiscard]] double mota() const;
};

// `map`: of the hall, or none.
Score follow_people(const HallSettings& settings, double seconds,
                    const localisation::LikelihoodField* map, const Stopwatch& stopwatch);

// --- a recorded drive

struct Mover {
  std::int32_t id = 0;
  double from = 0;  // s since the log began
  double to = 0;
  double way = 0;    // mm, from where it was first said to move to its farthest place
  double speed = 0;  // mm/s, mean
  double size = 0;   // mm
  MapPoint first{};  // places in the frame of the map or of the odometry
  MapPoint last{};
  double on_map = 0;  // share of its places where the map, if there is one, has something
  perception::ObjectKind kind{};
};

struct DriveScore {
  std::vector<Mover> movers{};
  std::size_t scans = 0;
  std::size_t objects = 0;  // confirmed ones, in all scans
  double minutes = 0;       // of recognition
  double us_per_scan = 0;
};

// When the scans were made, in s. Logging programs write several at once, with nearly the same
// time, though the scanner made them one after the other: if a log has such bunches, each scan has
// the mean time of its neighbours on both sides (pauses apart), else the time that the log says.
std::vector<double> even_times(const std::vector<localisation::LogScan>& scans);

struct DriveSettings {
  double lag = 0;                                      // s: scans are older than their time
  const localisation::LikelihoodField* map = nullptr;  // the robot is localised in it
  bool subtract = true;                                // else the map only judges
  std::uint64_t seed = 1;
};

DriveScore follow_drive(const localisation::CarmenLog& log, const DriveSettings& settings,
                        const Stopwatch& stopwatch);

}  // namespace rack::track_eval

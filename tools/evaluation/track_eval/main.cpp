// track-eval: evaluates the tracking of people and other moving objects.
#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

#include <fmt/core.h>

#include "base/statistics.h"
#include "tools/cli/argument_parser.h"
#include "tools/evaluation/mcl_eval/files.h"
#include "tools/evaluation/track_eval/tracking.h"

namespace rack::track_eval {
namespace {

using localisation::LikelihoodField;
using mcl_eval::print_line;
using mcl_eval::read_file;
using mcl_eval::stopwatch_us;
using mcl_eval::well;
using timsctl::Exit;
using timsctl::Failure;

struct Wanted {
  std::string log{};
  std::string map{};
  HallSettings hall{};
  double seconds = 300;
  std::uint64_t seeds = 1;
  std::optional<double> lag{};
  bool judge = false;
  bool list = false;
  bool json = false;
};

// --- people in a hall

LikelihoodField hall_field() {
  const auto map = localisation::read_map(Hall::plan(), 1000, 0, 0, 50);
  auto field = map ? LikelihoodField::of(*map, {}) : tims::Result<LikelihoodField>(map.error());
  if (!field) throw Failure(Exit::kNo, "no_map", field.error().detail());
  return std::move(field).value();
}

// Summary over all seeds.
void print_all(const std::vector<Score>& scores, bool json) {
  std::vector<double> mota;
  std::vector<double> off;
  std::vector<double> speed;
  std::vector<double> ghosts;
  std::vector<double> us;
  for (const Score& score : scores) {
    mota.push_back(score.mota());
    off.push_back(tims::base::mean(score.off) / 1000);
    speed.push_back(tims::base::mean(score.speed) / 1000);
    ghosts.push_back(score.ghosts / score.minutes);
    us.push_back(score.us_per_scan);
  }
  print_line({{"seeds", static_cast<double>(scores.size()), 0},
              {"mota", tims::base::mean(mota), 4},
              {"mota_worst", std::ranges::min(mota), 4},
              {"mean_m", tims::base::mean(off), 3},
              {"mean_m_s", tims::base::mean(speed), 3},
              {"mean_m_s_worst", std::ranges::max(speed), 3},
              {"ghosts_per_minute", tims::base::mean(ghosts), 2},
              {"us_per_scan", tims::base::mean(us), 1}},
             json);
}

Exit evaluate_people(Wanted wanted) {
  std::vector<Score> scores;
  std::optional<LikelihoodField> field;
  if (wanted.hall.localised) field = hall_field();
  for (std::uint64_t i = 0; i < wanted.seeds; ++i, ++wanted.hall.seed) {
    const Score score =
        follow_people(wanted.hall, wanted.seconds, field ? &*field : nullptr, stopwatch_us);
    scores.push_back(score);
    const auto share = [&](std::uint64_t count) {
      return static_cast<double>(count) / std::max(1.0, static_cast<double>(score.people));
    };
    print_line({{"seed", static_cast<double>(wanted.hall.seed), 0},
                {"mota", score.mota(), 4},
                {"missed", share(score.missed), 4},
                {"wrong", share(score.wrong), 4},
                {"switches", static_cast<double>(score.switches), 0},
                {"mean_m", tims::base::mean(score.off) / 1000, 3},
                {"mean_m_s", tims::base::mean(score.speed) / 1000, 3},
                {"p95_m_s", tims::base::quantile(score.speed, 0.95) / 1000, 3},
                {"ghosts_per_minute", score.ghosts / score.minutes, 2},
                {"us_per_scan", score.us_per_scan, 1}},
               wanted.json);
  }
  if (scores.size() > 1) print_all(scores, wanted.json);
  return Exit::kDone;
}

// --- a recorded drive

void print_mover(const Mover& mover, bool json) {
  print_line({{"id", static_cast<double>(mover.id), 0},
              {"from_s", mover.from, 1},
              {"to_s", mover.to, 1},
              {"distance_m", mover.distance / 1000, 2},
              {"mean_m_s", mover.speed / 1000, 2},
              {"size_m", mover.size / 1000, 2},
              {"type", static_cast<double>(mover.kind), 0},
              {"on_map", mover.on_map, 2},
              {"x_m", mover.first.x / 1000, 2},
              {"y_m", mover.first.y / 1000, 2},
              {"to_x_m", mover.last.x / 1000, 2},
              {"to_y_m", mover.last.y / 1000, 2}},
             json);
}

Exit evaluate_drive(const Wanted& wanted) {
  const auto log = well(localisation::read_carmen(read_file(wanted.log)), wanted.log);
  std::optional<LikelihoodField> field;
  if (!wanted.map.empty()) field = mcl_eval::field_of(mcl_eval::read_map(wanted.map), wanted.map);
  const DriveSettings settings{.lag = wanted.lag ? *wanted.lag : localisation::estimate_lag(log),
                               .map = field ? &*field : nullptr,
                               .subtract = !wanted.judge,
                               .seed = wanted.hall.seed};
  const DriveScore score = follow_drive(log, settings, stopwatch_us);
  if (wanted.list)
    for (const Mover& mover : score.movers) print_mover(mover, wanted.json);
  const double minutes = std::max(score.minutes, 1e-9);
  const auto on_map =
      std::ranges::count_if(score.movers, [](const Mover& m) { return m.on_map > 0.5; });
  print_line(
      {{"minutes", score.minutes, 2},
       {"scans", static_cast<double>(score.scans), 0},
       {"movers", static_cast<double>(score.movers.size()), 0},
       {"movers_per_minute", static_cast<double>(score.movers.size()) / minutes, 3},
       {"on_map", static_cast<double>(on_map), 0},
       {"objects_per_scan",
        static_cast<double>(score.objects) / std::max<double>(1, static_cast<double>(score.scans)),
        2},
       {"us_per_scan", score.us_per_scan, 1}},
      wanted.json);
  return Exit::kDone;
}

constexpr const char* kAbout =
    "Evaluate the tracking of people and other moving objects.\n\n"
    "Without LOG: simulated people in a hall with known positions, and a robot that drives among\n"
    "them. Prints one line per seed: mota (1 - missed, false and switched objects per visible\n"
    "person), mean_m, mean_m_s (errors of position and velocity), ghosts_per_minute (moving "
    "objects\n"
    "without a person), us_per_scan (CPU time); with several seeds a last line with means and "
    "worst.\n"
    "With LOG: prints the objects reported as moving on a recorded drive, for manual inspection.\n"
    "With MAP the robot is localised in it, and the objects of the map are ignored.";
constexpr const char* kExits =
    "Exit status: 0 done, 1 a file is invalid (FILE: line N: reason), 2 wrong command line, 4 no "
    "such\n"
    "file.";

void add_options(timsctl::ArgumentParser& parser, Wanted& wanted) {
  parser.argument("LOG", wanted.log, "CARMEN log, .clf");
  parser.argument("MAP", wanted.map,
                  "ROS map (.yaml, with its image in the same folder), or floor plan in m (DXF)");
  parser.option("--people", wanted.hall.people, "number of people in the hall", {0, 20});
  parser.option("--seconds", wanted.seconds, "length of each run [s]", {1.0, 86400.0});
  parser.option("--beams", wanted.hall.beams, "number of beams per scan", {2, 8000});
  parser.option("--opening", wanted.hall.opening, "field of view of the scanner [deg]",
                {1.0, 360.0});
  parser.option("--period", wanted.hall.period, "interval between scans [s]", {0.005, 1.0});
  parser.option("--noise", wanted.hall.noise, "standard deviation of ranges [mm]", {0.0, 200.0});
  parser.option("--robot-speed", wanted.hall.robot_speed, "speed of the robot [mm/s]",
                {0.0, 3000.0});
  parser.flag("--localised", wanted.hall.localised,
              "the robot has a map of the hall and knows its pose");
  parser.option("--seed", wanted.hall.seed, "seed of the random numbers");
  parser.option("--seeds", wanted.seeds, "number of runs with consecutive seeds", {1, 1000000});
  parser.option("--lag", wanted.lag, "age of scans in the log [s] (default: estimated from turns)",
                {-10.0, 10.0});
  parser.flag("--judge", wanted.judge,
              "use MAP only to report which movers are on occupied cells; do not subtract it");
  parser.flag("--list", wanted.list, "list all objects reported as moving");
  parser.flag("--json", wanted.json, "print one JSON object per line");
}

}  // namespace
}  // namespace rack::track_eval

int main(int argc, char** argv) {
  using namespace rack::track_eval;
  Wanted wanted;
  timsctl::ArgumentParser parser("track-eval", kAbout, kExits);
  add_options(parser, wanted);
  return parser.run(argc, argv, [&] {
    return wanted.log.empty() ? evaluate_people(wanted) : evaluate_drive(wanted);
  });
}

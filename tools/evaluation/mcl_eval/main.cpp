// mcl-eval: evaluates Monte Carlo localisation on a recorded drive.
#include <cstdio>
#include <optional>

#include <fmt/core.h>

#include "components/files/whole_file.h"
#include "components/position/map_file.h"
#include "tools/cli/argument_parser.h"
#include "tools/evaluation/mcl_eval/evaluation.h"
#include "tools/evaluation/mcl_eval/files.h"
#include "tools/evaluation/mcl_eval/table.h"

namespace rack::mcl_eval {
namespace {

using timsctl::Exit;
using timsctl::Failure;

struct Wanted {
  bool kidnap = false;
  std::string table{};                   // the folder of the public logs
  std::optional<std::uint64_t> seeds{};  // 1; of the table: 10
  std::optional<double> lag;
  bool json = false;
  std::string poses;  // file
  bool scan_matching = true;
  std::optional<double> field{};  // deg
};

std::vector<Field> fields_of(const Outcome& outcome) {
  std::vector<Field> fields{
      {"median_m", quantile(outcome.metres, 0.5), 4},
      {"p95_m", quantile(outcome.metres, 0.95), 4},
      {"max_m", quantile(outcome.metres, 1), 4},
      {"median_deg", quantile(outcome.degrees, 0.5), 3},
      {"p95_deg", quantile(outcome.degrees, 0.95), 3},
      {"lost", outcome.lost ? 1.0 : 0.0, 0},
      {"us_per_update", outcome.us_per_update, 1},
      {"mean_m", mean(outcome.metres), 4},
      {"mean_deg", mean(outcome.degrees), 3},
      {"over_1m", outcome.share_over_1m, 4},
      {"compared", static_cast<double>(outcome.metres.size()), 0},
      {"updates", static_cast<double>(outcome.updates), 0},
      {"recoveries", static_cast<double>(outcome.recoveries), 0},
  };
  if (outcome.found_after) fields.push_back({"found_after_m", *outcome.found_after, 1});
  if (outcome.refound_after) fields.push_back({"refound_after_m", *outcome.refound_after, 1});
  return fields;
}

// Mean and largest value of each result over all seeds.
void print_summary(const std::vector<std::vector<Field>>& all) {
  std::vector<Field> average = all.front();
  std::vector<Field> most = all.front();
  for (std::size_t i = 0; i < average.size(); ++i) {
    std::vector<double> values;
    for (const auto& fields : all)
      if (i < fields.size()) values.push_back(fields[i].value);
    average[i].value = mean(values);
    average[i].digits += 1;
    most[i].value = quantile(values, 1);
  }
  fmt::print("mean   {}\n", line_of(average, false));
  fmt::print("most   {}\n", line_of(most, false));
}

void write_poses(const std::string& file, const Outcome& outcome) {
  if (const auto written = rack::write_file(file, to_csv(outcome.poses)); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
}

Exit evaluate(const Files& files, Trial trial, const Wanted& wanted) {
  const auto log =
      well(localisation::read_carmen(read_file(files.log), wanted.field.value_or(0)), files.log);
  const auto map = read_map(files.map);
  const auto field = field_of(map, files.map);
  const localisation::WallLines walls(map);
  if (wanted.scan_matching) trial.walls = &walls;
  const Truth truth = well(read_truth(read_file(files.truth), log), files.truth);
  if (truth.beside > 0)
    fmt::print(stderr, "mcl-eval: {}: {} lines without a scan of that time are skipped\n",
               files.truth, truth.beside);
  if (wanted.kidnap) trial.kidnap = kidnapping(truth);
  if (wanted.kidnap && !trial.kidnap)
    throw Failure(Exit::kNo, "bad_file",
                  fmt::format("{}: --kidnap needs poses that are 10 m apart", files.truth));
  trial.lag = wanted.lag ? *wanted.lag : localisation::estimate_lag(log);
  if (!wanted.lag)
    fmt::print(stderr, "mcl-eval: {}: scans are {:.2f} s older than the odometry\n", files.log,
               trial.lag);
  bool lost = false;
  std::vector<std::vector<Field>> all;
  for (std::uint64_t i = 0; i < wanted.seeds.value_or(1); ++i, ++trial.seed) {
    trial.keep_poses = i == 0 && !wanted.poses.empty();
    const Outcome outcome = run(trial, log, field, truth, stopwatch_us);
    if (trial.keep_poses) write_poses(wanted.poses, outcome);
    const auto fields = fields_of(outcome);
    const std::string numbers = line_of(fields, wanted.json);
    fmt::print("{}\n", wanted.json ? fmt::format("{{\"seed\":{},{}}}", trial.seed, numbers)
                                   : fmt::format("seed={} {}", trial.seed, numbers));
    std::fflush(stdout);
    lost = lost || outcome.lost;
    all.push_back(fields);
  }
  if (all.size() > 1 && !wanted.json) print_summary(all);
  return lost ? Exit::kNo : Exit::kDone;
}

Recording read_recording(const std::string& folder, const std::string& name) {
  const std::string base = folder + "/" + name;
  auto log = well(localisation::read_carmen(read_file(base + ".clf")), base + ".clf");
  const auto truth = [&](const char* kind) {
    return well(read_truth(read_file(base + kind), log), base + kind);
  };
  Truth poses = truth(".poses.txt");
  Truth relations = name == "aces" ? truth(".relations") : Truth{};
  const auto map = read_map(base + "-map.yaml");
  return {name,
          std::move(log),
          field_of(map, base + "-map.yaml"),
          localisation::WallLines(map),
          std::move(poses),
          std::move(relations)};
}

Exit print_table(const Wanted& wanted) {
  const std::uint64_t seeds = wanted.seeds.value_or(10);
  std::vector<Recording> recordings;
  for (const char* name : {"aces", "intel", "fr079"})
    recordings.push_back(read_recording(wanted.table, name));
  static constexpr const char* kRow = "| {:<62} | {:>12} | {:>24} | {:<8} |\n";
  fmt::print(kRow, "requirement", "limit", fmt::format("measured, {} seeds", seeds), "");
  fmt::print("|---|--:|--:|---|\n");
  const bool held = measure(recordings, static_cast<std::uint32_t>(seeds), wanted.scan_matching,
                            stopwatch_us, [](const Row& row) {
                              fmt::print(kRow, row.what, row.wanted, row.measured,
                                         row.held ? "held" : "NOT HELD");
                              std::fflush(stdout);
                            });
  return held ? Exit::kDone : Exit::kNo;
}

constexpr const char* kAbout =
    "Evaluate Monte Carlo localisation on a recorded drive.\n\n"
    "The localiser receives the odometry and scans of the log, and its estimates are compared "
    "with\n"
    "TRUTH: poses of the laser in the frame of the map, as `time index x y theta` (index of the\n"
    "scan), `time x y theta` or `time x y z qx qy qz qw`, or relations between scans, as\n"
    "`time1 time2 dx dy dz roll pitch yaw`; m, rad, s. Prints one line per seed: errors of "
    "position\n"
    "and heading, lost (1: error above 1 m or 20 degrees at the end), us_per_update (CPU time),\n"
    "over_1m (fraction of compared poses), recoveries (updates that drew particles from the whole\n"
    "map), found_after_m (distance driven since a global start). Tracking starts with an error of\n"
    "half a metre and 15 degrees; with relations it starts at the pose found by a global start on\n"
    "the same log.";
constexpr const char* kExits =
    "Exit status: 0 done, 1 lost, a requirement did not hold, or a file is invalid (FILE: line N:\n"
    "reason), 2 wrong command line, 4 no such file, 5 a file cannot be written.";

void add_options(timsctl::ArgumentParser& parser, Files& files, Trial& trial, Wanted& wanted) {
  parser.argument("LOG", files.log, "CARMEN log, .clf");
  parser.argument("MAP", files.map,
                  "ROS map (.yaml, with its image in the same folder), or floor plan in m (DXF)");
  parser.argument("TRUTH", files.truth, "poses or relations");
  parser.option("--particles", trial.settings.filter.particles,
                "number of particles after convergence", {1, 1000000});
  parser.option("--beams", trial.settings.beams, "number of beams per scan that are used",
                {1, 10000});
  parser.option("--seed", trial.seed, "seed of the random numbers");
  parser.option("--seeds", wanted.seeds,
                "number of runs with consecutive seeds; then prints mean and largest values",
                {1, 1000000});
  parser.option("--lag", wanted.lag, "age of scans [s] (default: estimated from turns in the log)",
                {-10.0, 10.0});
  parser.flag("--global", trial.global, "global localisation: the start pose is unknown");
  parser.flag("--kidnap", wanted.kidnap, "kidnap the robot half-way: carry it at least 10 m away");
  parser.option("--odometry-scale", trial.odometry_scale,
                "factor of odometry distances; 1.1: 10 % too long", {0.1, 10.0});
  parser.option("--odometry-drift", trial.odometry_drift, "drift of the odometry heading [deg/m]",
                {-90.0, 90.0});
  parser.option("--short-beams", trial.short_beams,
                "fraction of beams that are shortened, as by people", {0.0, 1.0});
  parser.option("--poses", wanted.poses,
                "write the estimates and errors of the first seed for each scan to this CSV file;\n"
                "`timsctl nav plot` draws it");
  parser.option(
      "--table", wanted.table,
      "instead of LOG MAP TRUTH: folder with the public logs aces, intel and fr079, their "
      "maps and\nground truth, uncompressed; prints requirements and measured values (10 seeds "
      "by default)");
  parser.option("--field-of-view", wanted.field,
                "field of view of FLASER [deg] (default: 180, or that of known scanners with so "
                "many beams)",
                {1.0, 360.0});
  parser.flag("--scan-matching,!--no-scan-matching", wanted.scan_matching,
              "refine each estimate by matching the scan with the walls of the map (default);\n"
              "--no-scan-matching: only the filter");
  parser.flag("--json", wanted.json, "print one JSON object per line");
}

}  // namespace
}  // namespace rack::mcl_eval

int main(int argc, char** argv) {
  using namespace rack::mcl_eval;
  Files files;
  Trial trial;
  Wanted wanted;
  timsctl::ArgumentParser parser("mcl-eval", kAbout, kExits);
  add_options(parser, files, trial, wanted);
  return parser.run(argc, argv, [&] {
    if (wanted.table.empty() == files.truth.empty())
      throw timsctl::usage_error("LOG, MAP and TRUTH are required, or only --table");
    trial.settings.filter.particles_max =
        std::max(trial.settings.filter.particles_max, trial.settings.filter.particles);
    return wanted.table.empty() ? evaluate(files, trial, wanted) : print_table(wanted);
  });
}

// mcl-eval: how well Monte Carlo localisation does on a recorded drive.
#include <cstdio>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "components/position/map_file.h"
#include "tools/cli/failure.h"
#include "tools/evaluation/mcl_eval/evaluation.h"
#include "tools/evaluation/mcl_eval/files.h"
#include "tools/evaluation/mcl_eval/table.h"

namespace rack::mcl_eval {
namespace {

using timsctl::Exit;
using timsctl::Failure;

struct Wanted {
  bool kidnap = false;
  std::string table{};  // the folder of the public logs
  std::uint64_t seeds = 1;
  std::optional<double> lag;
  bool json = false;
  std::string poses;  // file
  bool scan_matching = true;
  double field = 0;
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

// Each number's mean over all seeds, and the largest.
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
  if (const auto written = navigation::write_file(file, to_csv(outcome.poses)); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
}

Exit evaluate(const Files& files, Trial trial, const Wanted& wanted) {
  const auto log = well(localisation::read_carmen(read_file(files.log), wanted.field), files.log);
  const auto map = read_map(files.map);
  const auto field = field_of(map, files.map);
  const localisation::WallLines walls(map);
  if (wanted.scan_matching) trial.walls = &walls;
  const Truth truth = well(read_truth(read_file(files.truth), log), files.truth);
  if (truth.beside > 0)
    fmt::print(stderr, "mcl-eval: {}: {} lines of times that no scan has are left out\n",
               files.truth, truth.beside);
  if (wanted.kidnap) trial.kidnap = kidnapping(truth);
  if (wanted.kidnap && !trial.kidnap)
    throw Failure(Exit::kNo, "bad_file",
                  fmt::format("{}: --kidnap needs poses that are 10 m apart", files.truth));
  trial.lag = wanted.lag ? *wanted.lag : localisation::estimate_lag(log);
  if (!wanted.lag)
    fmt::print(stderr, "mcl-eval: {}: its scans are {:.2f} s older than its odometry\n", files.log,
               trial.lag);
  bool lost = false;
  std::vector<std::vector<Field>> all;
  for (std::uint64_t i = 0; i < wanted.seeds; ++i, ++trial.seed) {
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
  std::vector<Recording> recordings;
  for (const char* name : {"aces", "intel", "fr079"})
    recordings.push_back(read_recording(wanted.table, name));
  static constexpr const char* kRow = "| {:<62} | {:>12} | {:>24} | {:<8} |\n";
  fmt::print(kRow, "what", "wanted", fmt::format("measured, {} seeds", wanted.seeds), "");
  fmt::print("|---|--:|--:|---|\n");
  const bool held = measure(recordings, static_cast<std::uint32_t>(wanted.seeds),
                            wanted.scan_matching, stopwatch_us, [](const Row& row) {
                              fmt::print(kRow, row.what, row.wanted, row.measured,
                                         row.held ? "held" : "NOT HELD");
                              std::fflush(stdout);
                            });
  return held ? Exit::kDone : Exit::kNo;
}

constexpr const char* kAbout =
    "How well Monte Carlo localisation does on a recorded drive.\n\n"
    "The localiser gets the log's odometry and scans, what it says is compared with TRUTH: poses "
    "in\n"
    "the frame of the map, as `time index x y theta` (index of the scan) or `time x y theta`, or\n"
    "`time x y z qx qy qz qw`, or relations between scans, as `time1 time2 dx dy dz roll pitch "
    "yaw`; m, rad, s. One line a "
    "seed:\n"
    "errors of positions and headings, lost (1: more than 1 m or 20 degrees off at the end),\n"
    "us_per_update (time of the processor), over_1m (share of the compared), recoveries (updates\n"
    "that drew particles anew all over the map), found_after_m (driven since a global start).\n"
    "Tracking starts half a metre and 15 degrees beside the truth; with relations it starts where\n"
    "a global start on the same log says that it began.";
constexpr const char* kExits =
    "Exit status: 0 done, 1 lost, not held, or a file is broken (FILE: line N: what), 2 wrong "
    "command line,\n"
    "4 no such file, 5 a file cannot be written.";

void add_options(CLI::App& app, Files& files, Trial& trial, Wanted& wanted) {
  app.add_option("LOG", files.log, "log of CARMEN, .clf");
  app.add_option("MAP", files.map,
                 "map of ROS (.yaml, its picture beside it), or floor plan in m (DXF)");
  app.add_option("TRUTH", files.truth, "poses or relations");
  app.add_option("--particles", trial.settings.filter.particles, "while it knows where it is")
      ->capture_default_str()
      ->check(CLI::Range(1U, 1000000U));
  app.add_option("--beams", trial.settings.beams, "of each scan")
      ->capture_default_str()
      ->check(CLI::Range(1U, 10000U));
  app.add_option("--seed", trial.seed, "of all that is random")->capture_default_str();
  app.add_option("--seeds", wanted.seeds, "one run after the other; then their mean and most")
      ->check(CLI::Range(1U, 1000000U));
  app.add_option("--lag", wanted.lag, "age of scans, s (default: seen from the log's turns)")
      ->check(CLI::Range(-10.0, 10.0));
  app.add_flag("--global", trial.global, "it does not know where it starts");
  app.add_flag("--kidnap", wanted.kidnap, "half-way it is carried 10 m away");
  app.add_option("--odometry-scale", trial.odometry_scale, "1.1: ways are said 10 % too long")
      ->check(CLI::Range(0.1, 10.0));
  app.add_option("--odometry-drift", trial.odometry_drift, "deg/m")->check(CLI::Range(-90.0, 90.0));
  app.add_option("--short-beams", trial.short_beams, "share of beams that people cut short")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--poses", wanted.poses,
                 "file for what was said at each scan, and how far off: columns with names between "
                 "commas, of\nthe first seed; `timsctl nav plot` draws it");
  app.add_option("--table", wanted.table,
                 "instead of LOG MAP TRUTH: folder of the public logs aces, intel and fr079, their "
                 "maps and truths,\nunpacked; prints what has to be reached and what was, in 10 "
                 "seeds unless --seeds says otherwise");
  app.add_option("--field-of-view", wanted.field,
                 "of FLASER, degrees (default: 180, or what scanners of so many beams have)")
      ->check(CLI::Range(1.0, 360.0));
  app.add_flag("--scan-matching,!--no-scan-matching", wanted.scan_matching,
               "lay each scan on the walls of the map at last (default); --no-scan-matching: the "
               "filter alone");
  app.add_flag("--json", wanted.json, "a JSON object a line");
  app.set_version_flag("--version", TIMS_VERSION);
  app.footer(kExits);
}

}  // namespace
}  // namespace rack::mcl_eval

int main(int argc, char** argv) {
  using namespace rack::mcl_eval;
  Files files;
  Trial trial;
  Wanted wanted;
  CLI::App app(kAbout, "mcl-eval");
  add_options(app, files, trial, wanted);
  return timsctl::run_program(argc, argv, app, [&] {
    if (wanted.table.empty() == files.truth.empty())
      throw CLI::ValidationError("LOG, MAP and TRUTH are needed, or --table alone");
    if (app.count("--seeds") == 0 && !wanted.table.empty()) wanted.seeds = 10;
    trial.settings.filter.particles_max =
        std::max(trial.settings.filter.particles_max, trial.settings.filter.particles);
    return wanted.table.empty() ? evaluate(files, trial, wanted) : print_table(wanted);
  });
}

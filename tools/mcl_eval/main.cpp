// mcl-eval: how well Monte Carlo localisation does on a recorded drive.
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "components/localisation/ros_map.h"
#include "tools/cli/failure.h"
#include "tools/mcl_eval/evaluation.h"

namespace rack::mcl_eval {
namespace {

using timsctl::Exit;
using timsctl::Failure;

struct Files {
  std::string log;
  std::string map;
  std::string truth;
};

std::string read_file(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file || std::filesystem::is_directory(name))
    throw Failure(Exit::kNoSuch, "no_such_file", fmt::format("{}: cannot be read", name));
  if (bytes.starts_with("\xFD" "7zXZ"))
    throw Failure(Exit::kNo, "bad_file", fmt::format("{}: packed", name), "unpack it: xz -dk FILE");
  return bytes;
}

template <typename T>
T well(tims::Result<T> result, const std::string& file) {
  if (!result)
    throw Failure(Exit::kNo, "bad_file", fmt::format("{}: {}", file, result.error().detail()));
  return std::move(result).value();
}

localisation::GridMap read_map_file(const std::string& name) {
  const auto info = well(localisation::read_ros_yaml(read_file(name)), name);
  const std::filesystem::path image = std::filesystem::path(name).parent_path() / info.image;
  return well(localisation::read_ros_map(info, read_file(image)), image);
}

// Of this thread alone: others on this machine do not count.
double stopwatch_us() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) / 1e3;
}

struct Field {
  std::string name;
  double value;
  int digits;
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

void print(const Outcome& outcome, std::uint64_t seed, bool json) {
  std::string line = json ? fmt::format("{{\"seed\":{}", seed) : fmt::format("seed={}", seed);
  for (const Field& field : fields_of(outcome))
    line += json ? fmt::format(",\"{}\":{:.{}f}", field.name, field.value, field.digits)
                 : fmt::format(" {}={:.{}f}", field.name, field.value, field.digits);
  fmt::print("{}{}\n", line, json ? "}" : "");
}

Exit evaluate(const Files& files, Trial trial, std::optional<double> lag, std::uint64_t seeds,
              bool json) {
  const auto log = well(localisation::read_carmen(read_file(files.log)), files.log);
  const auto map = read_map_file(files.map);
  const auto field = well(localisation::LikelihoodField::of(map, {}), files.map);
  const Truth truth = well(read_truth(read_file(files.truth), log), files.truth);
  if (truth.beside > 0)
    fmt::print(stderr, "mcl-eval: {}: {} lines of times that no scan has are left out\n",
               files.truth, truth.beside);
  trial.lag = lag ? *lag : localisation::estimate_lag(log);
  if (!lag && !json) fmt::print(stderr, "mcl-eval: scans are {:.3f} s old\n", trial.lag);
  bool lost = false;
  for (std::uint64_t i = 0; i < seeds; ++i, ++trial.seed) {
    const Outcome outcome = run(trial, log, field, truth, stopwatch_us);
    print(outcome, trial.seed, json);
    std::fflush(stdout);
    lost = lost || outcome.lost;
  }
  return lost ? Exit::kNo : Exit::kDone;
}

}  // namespace
}  // namespace rack::mcl_eval

int main(int argc, char** argv) {
  using namespace rack::mcl_eval;
  Files files;
  Trial trial;
  std::optional<double> lag;
  std::uint64_t seeds = 1;
  bool json = false;
  CLI::App app("How well Monte Carlo localisation does on a recorded drive.", "mcl-eval");
  app.add_option("LOG", files.log, "log of CARMEN (.clf)")->required();
  app.add_option("MAP", files.map, "map of ROS (.yaml, beside its .pgm)")->required();
  app.add_option("TRUTH", files.truth, "poses (time [index] x y theta) or relations")->required();
  app.add_option("--particles", trial.settings.filter.particles);
  app.add_option("--beams", trial.settings.beams);
  app.add_option("--seed", trial.seed);
  app.add_option("--seeds", seeds);
  app.add_option("--lag", lag);
  app.add_option("--every", trial.settings.way_between);
  app.add_option("--odometry-scale", trial.odometry_scale);
  app.add_option("--odometry-drift", trial.odometry_drift);
  app.add_option("--short-beams", trial.short_beams);
  app.add_option("--sharpness", trial.settings.filter.sharpness);
  app.add_option("--tt", trial.settings.filter.turn_by_turn);
  app.add_option("--tw", trial.settings.filter.turn_by_way);
  app.add_option("--ww", trial.settings.filter.way_by_way);
  app.add_option("--sw", trial.settings.filter.side_by_way);
  app.add_option("--slip", trial.settings.filter.slip_share);
  app.add_option("--slipt", trial.settings.filter.slip_times);
  app.add_option("--tl", trial.settings.filter.turn_least);
  app.add_option("--wl", trial.settings.filter.way_least);
  app.add_option("--slow", trial.settings.filter.average_slow);
  app.add_option("--fast", trial.settings.filter.average_fast);
  app.add_option("--rm", trial.settings.filter.recovery_margin);
  app.add_option("--jm", trial.settings.filter.jump_margin);
  app.add_flag("--global", trial.global);
  app.add_flag("--kidnap", trial.kidnap);
  app.add_flag("--json", json);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(Exit::kUsage);
  }
  try {
    return static_cast<int>(evaluate(files, trial, lag, seeds, json));
  } catch (const Failure& failure) {
    fmt::print(stderr, "mcl-eval: {}{}{}\n", failure.message, failure.hint.empty() ? "" : "; ",
               failure.hint);
    return static_cast<int>(failure.exit);
  }
}

// mrpt-bench: compares MRPT's particle filter with ours on the same recorded drives, in one table.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <fmt/core.h>

#include "tests/bench/mrpt/mrpt_filter.h"
#include "tools/cli/argument_parser.h"
#include "tools/evaluation/mcl_eval/files.h"

namespace rack::mcl_eval {
namespace {

using localisation::BeamEnd;
using localisation::GridMap;
using timsctl::Exit;
using timsctl::Failure;

struct RecordedDrive {
  localisation::CarmenLog log;
  GridMap map;
  localisation::LikelihoodField field;
  Truth truth;
  double lag;  // s
};

RecordedDrive read_drive(const Files& files) {
  auto log = well(localisation::read_carmen(read_file(files.log)), files.log);
  auto map = read_map(files.map);
  auto field = field_of(map, files.map);
  auto truth = well(read_truth(read_file(files.truth), log), files.truth);
  const double lag = localisation::estimate_lag(log);
  return {std::move(log), std::move(map), std::move(field), std::move(truth), lag};
}

struct Wanted {
  std::vector<std::string> files{};  // log, map, truth; repeated
  std::vector<unsigned> particles{500, 2000};
  std::vector<unsigned> beams{60, 180};
  std::uint64_t seed = 1;
  std::uint64_t seeds = 10;
  bool proof = false;
  bool alone = false;
  MrptSettings mrpt{};
};

// Checks whether MRPT gets map and scans correctly: how often a scan is more likely at the true
// pose than at shifted and rotated ones.
void prove(const RecordedDrive& drive, const Wanted& wanted, const std::string& name) {
  const MrptFilter filter(wanted.mrpt, drive.map, wanted.seed);
  constexpr double kBeside = 300;  // mm
  constexpr double kTurned = radians(5);
  constexpr std::array kOff{Pose{.x = kBeside},  Pose{.x = -kBeside},  Pose{.y = kBeside},
                            Pose{.y = -kBeside}, Pose{.rho = kTurned}, Pose{.rho = -kTurned}};
  std::array<std::size_t, kOff.size()> likelier{};
  std::vector<BeamEnd> beams;
  for (const TruePose& at : drive.truth.poses) {
    const auto& scan = drive.log.scans[at.scan];
    drive.log.beams(scan, beams);
    const Pose robot = at.laser + (Pose{} - scan.laser);
    const double here = filter.likelihood(robot, scan, beams);
    for (std::size_t i = 0; i < kOff.size(); ++i)
      if (here > filter.likelihood(robot + kOff.at(i), scan, beams)) ++likelier.at(i);
  }
  const auto share = [&](std::size_t i) {
    return 100 * static_cast<double>(likelier.at(i)) /
           static_cast<double>(std::max<std::size_t>(1, drive.truth.poses.size()));
  };
  fmt::print(
      "{}: share of {} scans that are more likely at the true pose than 0.3 m ahead {:.1f} %, "
      "behind {:.1f} %, right {:.1f} %, left {:.1f} %, rotated by 5 degrees {:.1f} %, {:.1f} "
      "%\n",
      name, drive.truth.poses.size(), share(0), share(1), share(2), share(3), share(4), share(5));
}

void print_row(const std::string& name, const std::string& implementation, const Wanted& wanted,
               std::size_t size, const std::vector<Outcome>& all) {
  const auto average = [&](auto value) {
    double sum = 0;
    for (const Outcome& outcome : all) sum += value(outcome);
    return sum / static_cast<double>(all.size());
  };
  double most = 0;
  for (const Outcome& outcome : all) most = std::max(most, quantile(outcome.metres, 1));
  fmt::print(
      "| {} | {} | {} | {} | {:.4f} | {:.4f} | {:.3f} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {} of "
      "{} | {:.0f} |\n",
      name, wanted.particles[size], wanted.beams[size], implementation,
      average([](const Outcome& o) { return mean(o.metres); }),
      average([](const Outcome& o) { return quantile(o.metres, 0.5); }),
      average([](const Outcome& o) { return quantile(o.metres, 0.95); }), most,
      average([](const Outcome& o) { return mean(o.degrees); }),
      average([](const Outcome& o) { return quantile(o.degrees, 0.5); }),
      100 * average([](const Outcome& o) { return o.share_over_1m; }),
      std::ranges::count_if(all, &Outcome::lost), all.size(),
      average([](const Outcome& o) { return o.us_per_update; }));
  std::fflush(stdout);
}

void compare(const RecordedDrive& drive, const Wanted& wanted, std::size_t size,
             const std::string& name) {
  std::vector<Outcome> ours;
  std::vector<Outcome> theirs;
  Trial trial{.lag = drive.lag};
  trial.settings.filter.particles = wanted.particles[size];
  trial.settings.beams = wanted.beams[size];
  MrptSettings settings = wanted.mrpt;
  settings.particles = wanted.particles[size];
  settings.beams = wanted.beams[size];
  // Summing the logarithms of three times as many beams, as if they were independent, makes the
  // filter three times as certain.
  settings.power *= 60.0 / settings.beams;
  for (trial.seed = wanted.seed; trial.seed < wanted.seed + wanted.seeds; ++trial.seed) {
    if (!wanted.alone)
      ours.push_back(run(trial, drive.log, drive.field, drive.truth, stopwatch_us));
    MrptFilter mrpt(settings, drive.map, trial.seed);
    theirs.push_back(run(trial, drive.log, drive.field, drive.truth, stopwatch_us, mrpt));
  }
  if (!wanted.alone) print_row(name, "ours", wanted, size, ours);
  print_row(name, "MRPT", wanted, size, theirs);
}

Exit bench(const Wanted& wanted) {
  if (!wanted.proof)
    fmt::print(
        "| log | particles | beams | filter | mean m | median m | 95 % m | max m | mean degrees | "
        "median "
        "degrees | over 1 m % | lost at the end | us an update |\n"
        "|---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (std::size_t i = 0; i + 2 < wanted.files.size(); i += 3) {
    const Files files{wanted.files[i], wanted.files[i + 1], wanted.files[i + 2]};
    const RecordedDrive drive = read_drive(files);
    const std::string name = std::filesystem::path(files.log).stem();
    if (wanted.proof) {
      prove(drive, wanted, name);
      continue;
    }
    for (std::size_t size = 0; size < wanted.particles.size(); ++size)
      compare(drive, wanted, size, name);
  }
  return Exit::kDone;
}

constexpr const char* kAbout =
    "MRPT's particle filter " MRPT_RELEASE
    " and ours on the same recorded drives, compared in one table.\n\n"
    "Both get the same scans, beams, odometry and start, as in mcl-eval.";

void add_options(timsctl::ArgumentParser& parser, Wanted& wanted) {
  parser.arguments("LOG MAP TRUTH", wanted.files, "files as for mcl-eval; any number of triples");
  parser.option("--particles", wanted.particles, "numbers of particles to compare");
  parser.option("--beams", wanted.beams, "numbers of beams, one for each of --particles");
  parser.option("--seed", wanted.seed, "first seed");
  parser.option("--seeds", wanted.seeds, "number of seeds");
  parser.flag("--proof", wanted.proof, "only check whether scans are more likely at the true pose");
  parser.flag("--alone", wanted.alone, "run only the filter of MRPT");
  MrptSettings& mrpt = wanted.mrpt;
  const auto setting = [&parser](const char* name, double& value, const std::string& what) {
    parser.option(name, value, "of MRPT: " + what);
  };
  setting("--a1", mrpt.a1, "gaussianModel: m/m");
  setting("--a2", mrpt.a2, "m/rad");
  setting("--a3", mrpt.a3, "rad/m");
  setting("--a4", mrpt.a4, "rad/rad");
  setting("--min-std-xy", mrpt.min_std_xy, "m");
  setting("--min-std-phi", mrpt.min_std_phi, "rad");
  setting("--std-hit", mrpt.std_hit, "LF_stdHit, m");
  setting("--max-distance", mrpt.max_distance, "LF_maxCorrsDistance, m");
  setting("--z-hit", mrpt.z_hit, "LF_zHit; LF_zRandom is 1 - LF_zHit");
  setting("--max-range", mrpt.max_range, "LF_maxRange, m");
  setting("--power", mrpt.power, "powFactor for 60 beams; scaled inversely with their number");
  setting("--beta", mrpt.beta, "BETA: resample below this share of the effective sample size");
  parser.flag("--optimal", mrpt.optimal, "of MRPT: pfAuxiliaryPFOptimal, not pfStandardProposal");
}

}  // namespace
}  // namespace rack::mcl_eval

int main(int argc, char** argv) {
  using namespace rack::mcl_eval;
  Wanted wanted;
  timsctl::ArgumentParser parser("mrpt-bench", kAbout);
  add_options(parser, wanted);
  return parser.run(argc, argv, [&] {
    if (wanted.files.empty() || wanted.files.size() % 3 != 0)
      throw timsctl::usage_error("files must be given as triples LOG MAP TRUTH");
    if (wanted.particles.size() != wanted.beams.size())
      throw timsctl::usage_error("--beams needs one value for each of --particles");
    try {
      return bench(wanted);
    } catch (const Failure&) {
      throw;
    } catch (const std::exception& error) {
      throw Failure(Exit::kNo, "mrpt", error.what());
    }
  });
}

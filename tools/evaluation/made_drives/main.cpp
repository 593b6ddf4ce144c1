// made-drive: writes a drive through a building that does not exist, with its true poses.
#include <string>

#include "components/files/whole_file.h"
#include "tools/cli/argument_parser.h"
#include "tools/evaluation/made_drives/made_drive.h"

namespace rack::made_drives {
namespace {

struct Wanted {
  std::string site;
  std::string name;
  DriveKind kind{};
  std::uint32_t people = 3;
  std::uint32_t beams = 181;
  double drift = 0.7;    // deg/m
  double slip_turn = 6;  // deg
};

void write(const std::string& name, const std::string& text) {
  if (const auto written = rack::write_file(name, text); !written)
    throw timsctl::Failure(timsctl::Exit::kDenied, "not_written", written.error().detail());
}

timsctl::Exit make(Wanted wanted) {
  wanted.kind.people = wanted.people;
  wanted.kind.beams = wanted.beams;
  wanted.kind.drift = radians(wanted.drift);
  wanted.kind.slip_turn = radians(wanted.slip_turn);
  const bool is_campus = wanted.site == "campus";
  if (!is_campus && wanted.site != "laboratory")
    throw timsctl::usage_error("\"" + wanted.site + "\": the site is laboratory or campus");
  const auto scans =
      drive(is_campus ? campus(wanted.kind.seed) : laboratory(wanted.kind.seed), wanted.kind);
  write(wanted.name + ".clf", to_carmen(scans));
  write(wanted.name + ".poses", to_truth(scans));
  return timsctl::Exit::kDone;
}

}  // namespace
}  // namespace rack::made_drives

int main(int argc, char** argv) {
  using namespace rack::made_drives;
  Wanted wanted;
  timsctl::ArgumentParser parser(
      "made-drive",
      "Write a drive through a made building: NAME.clf, a CARMEN log, and NAME.poses, its true "
      "poses.",
      "Then: map-maker NAME.clf NAME.yaml --truth NAME.poses");
  parser.required_argument("SITE", wanted.site, "laboratory (0.4 km) or campus (1.9 km)");
  parser.required_argument("NAME", wanted.name, "output files, without .clf");
  parser.option("--seed", wanted.kind.seed, "of the building, the noise and the people");
  parser.option("--beams", wanted.beams, "of a scan of 180 degrees", {2, 10000});
  parser.option("--range", wanted.kind.range_max, "longest beam [m]", {1.0, 1000.0});
  parser.option("--length", wanted.kind.length, "end of the drive [m]", {1.0, 1e6});
  parser.option("--every", wanted.kind.scan_distance, "distance between scans [m]", {0.02, 2.0});
  parser.option("--noise", wanted.kind.range_noise, "of ranges [m]", {0.0, 1.0});
  parser.option("--scale", wanted.kind.scale, "error of distances of the odometry [share]",
                {0.0, 0.3});
  parser.option("--drift", wanted.drift, "turn of the odometry [deg/m]", {0.0, 20.0});
  parser.option("--slip-turn", wanted.slip_turn, "turn when wheels slip [deg]", {0.0, 90.0});
  parser.option("--people", wanted.people, "number of people near the robot", {0, 100});
  return parser.run(argc, argv, [&] { return make(wanted); });
}

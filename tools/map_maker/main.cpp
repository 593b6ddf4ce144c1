// map-maker: builds a map of a building from a recorded drive through it.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <fmt/core.h>
#include <unistd.h>

#include "components/files/whole_file.h"
#include "components/localisation/ros_map.h"
#include "components/mapping/map_maker.h"
#include "components/mapping/occupancy.h"
#include "components/pictures/grey_picture.h"
#include "components/pictures/png_file.h"
#include "components/position/map_file.h"
#include "os/file.h"
#include "tools/cli/argument_parser.h"
#include "tools/evaluation/mcl_eval/evaluation.h"
#include "tools/evaluation/mcl_eval/files.h"
#include "tools/evaluation/mcl_eval/truth.h"
#include "tools/map_maker/doubts_picture.h"
#include "tools/map_maker/warnings.h"

namespace rack::map_maker {
namespace {

using mapping::Drive;
using mapping::MadeMap;
using mcl_eval::Field;
using mcl_eval::read_file;
using mcl_eval::well;
using timsctl::Exit;
using timsctl::Failure;

struct Wanted {
  std::string log;
  std::string map;
  std::string odometry;  // a recording of odometry
  std::string poses;     // output file
  std::string truth;
  std::string image = "pgm";  // or "png"
  std::string picture;        // output file
  std::optional<double> lag;
  double resolution = 0.05;  // m
  double range = 30;         // m
  mapping::MapSettings settings{};
  bool json = false;
  bool quiet = false;
};

std::atomic<bool> interrupted = false;

// --- input

struct Input {
  Drive drive{};
  std::optional<localisation::CarmenLog> log{};  // empty: a recording
  double lag = 0;
};

Input read_carmen(const Wanted& wanted, const std::string& text) {
  Input input;
  input.log = well(localisation::read_carmen(text), wanted.log);
  input.lag = wanted.lag ? *wanted.lag : localisation::estimate_lag(*input.log);
  input.drive = mapping::drive_of(*input.log, input.lag);
  return input;
}

// The files of single scans are in the folder of the Scan2d file, with this name.
Input read_recording(const Wanted& wanted, const std::string& text) {
  if (wanted.odometry.empty())
    throw Failure(Exit::kUsage, "usage",
                  fmt::format("{}: a recording of a Scan2d contains no odometry", wanted.log),
                  "add the recording of Odometry or Position with --odometry FILE");
  const std::filesystem::path path(wanted.log);
  const std::string base = (path.parent_path() / path.stem()).string();
  const auto scan_file = [&](std::size_t number) {
    return tims::os::read_file(fmt::format("{}_{}.2d", base, number));
  };
  Input input;
  input.drive =
      well(mapping::read_recording(read_file(wanted.odometry), text, scan_file), wanted.log);
  return input;
}

Input read_input(const Wanted& wanted) {
  const std::string text = read_file(wanted.log);
  Input input = text.starts_with("% ") ? read_recording(wanted, text) : read_carmen(wanted, text);
  if (!wanted.truth.empty() && !input.log)
    throw Failure(Exit::kUsage, "usage", "--truth requires a CARMEN log");
  return input;
}

// --- progress

class ProgressLine {
 public:
  explicit ProgressLine(bool quiet)
      : shown_(!quiet && ::isatty(STDERR_FILENO) == 1), quiet_(quiet) {}
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() {
    if (shown_) fmt::print(stderr, "\r\033[K");
  }
  // On a terminal one line is updated; elsewhere one line per step is printed.
  bool operator()(std::string_view what, std::size_t done, std::size_t all) {
    const std::size_t percent = all > 0 ? 100 * done / all : 100;
    if (shown_ && (what != what_ || percent != percent_))
      fmt::print(stderr, "\r\033[Kmap-maker: {} ... {} %", what, percent);
    if (!shown_ && !quiet_ && what != what_) fmt::print(stderr, "map-maker: {} ...\n", what);
    what_ = what;
    percent_ = percent;
    return !interrupted;
  }

 private:
  bool shown_;
  bool quiet_;
  std::string what_;
  std::size_t percent_ = 0;
};

// --- output

void write_file(const std::string& name, const std::string& text) {
  if (const auto written = rack::write_file(name, text); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
}

std::vector<Pose> laser_poses(const Drive& drive, const MadeMap& made) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < made.poses.size(); ++i)
    poses.push_back(made.poses[i] + drive.scans[i].scanner);
  return poses;
}

// The image is written first: a reader of the new YAML file must find it.
void write_map(const Wanted& wanted, const MadeMap& made) {
  const std::filesystem::path yaml(wanted.map);
  std::filesystem::path picture = yaml;
  picture.replace_extension("." + wanted.image);
  const auto format =
      wanted.image == "png" ? pictures::GreyFormat::kPng : pictures::GreyFormat::kPgm;
  write_file(picture.string(),
             well(pictures::write_grey(localisation::grey_of(made.map), format), picture.string()));
  write_file(wanted.map, localisation::to_ros_yaml(made.map, picture.filename().string()));
}

// The picture of what contradicts the map.
void write_picture(const std::string& name, const MadeMap& made) {
  const ColourPicture picture = draw_doubts(made);
  const pictures::PixelView pixels{.layout = pictures::PixelLayout::kRgb,
                                   .size = {static_cast<std::uint32_t>(picture.width),
                                            static_cast<std::uint32_t>(picture.height)},
                                   .bytes = picture.rgb};
  const auto png = well(pictures::encode_png({.pixels = pixels}), name);
  write_file(name, {reinterpret_cast<const char*>(png.data()), png.size()});
}

void warn(const Wanted& wanted, const MadeMap& made, const std::string& picture) {
  for (const std::string& warning : warnings(made, wanted.settings, picture))
    fmt::print(stderr, "map-maker: warning: {}\n", warning);
}

// What the work will need, before it begins.
void announce(const Wanted& wanted, const Drive& drive) {
  constexpr double kManyCells = 16e6;
  const double cells = mapping::expected_cells(drive, wanted.settings);
  if (wanted.quiet || cells <= kManyCells) return;
  fmt::print(stderr,
             "map-maker: by the odometry, the map will have about {:.0f} million cells of {:.0f} "
             "mm (at most {} million): --resolution and --range reduce it\n",
             cells / 1e6, wanted.settings.resolution, mapping::Occupancy::kCellsMax / 1'000'000);
}

void write_poses(const Wanted& wanted, const Drive& drive, std::span<const Pose> laser) {
  std::string text = "# time index x y theta (of the scanner)\n";
  for (std::size_t i = 0; i < laser.size(); ++i) {
    const auto pose = localisation::ros_of_pose(laser[i]);
    text += fmt::format("{:.6f} {} {:.4f} {:.4f} {:.5f}\n", drive.scans[i].time, drive.scans[i].row,
                        pose.x, pose.y, pose.theta);
  }
  write_file(wanted.poses, text);
}

std::vector<Field> fields_of(const Input& input, const MadeMap& made) {
  const localisation::GridMap& map = made.map;
  return {
      {"scans", static_cast<double>(input.drive.scans.size()), 0},
      {"left_out", static_cast<double>(input.drive.left_out), 0},
      {"lag_s", input.lag, 2},
      {"distance_m", made.distance / 1000, 1},
      {"keyframes", static_cast<double>(made.keyframes), 0},
      {"searched", static_cast<double>(made.searched), 0},
      {"unmatched", static_cast<double>(made.unmatched), 0},
      {"loops", static_cast<double>(made.loops), 0},
      {"removed", static_cast<double>(made.removed), 0},
      {"edges", static_cast<double>(made.edges), 0},
      {"compared_m", made.doubts.compared / 1000, 1},
      {"doubtful_m", made.doubts.distance / 1000, 1},
      {"without_loop_m", made.without_loop.distance / 1000, 1},
      {"uncertain_m", made.uncertain / 1000, 2},
      {"width_m", map.columns * map.resolution / 1000, 2},
      {"height_m", map.rows * map.resolution / 1000, 2},
      {"occupied", static_cast<double>(map.count(localisation::Cell::kOccupied)), 0},
      {"free", static_cast<double>(map.count(localisation::Cell::kFree)), 0},
  };
}

void add_error(const Wanted& wanted, const Input& input, std::span<const Pose> laser,
               std::vector<Field>& fields) {
  const auto truth = well(mcl_eval::read_truth(read_file(wanted.truth), *input.log), wanted.truth);
  const mcl_eval::TrackError error = mcl_eval::track_error(laser, truth);
  const double middle = mcl_eval::mean(error.metres);
  double squares = 0;
  for (const double metres : error.metres) squares += (metres - middle) * (metres - middle);
  const auto count = static_cast<double>(error.metres.size());
  fields.push_back({"compared", count, 0});
  fields.push_back({"mean_m", middle, 4});
  fields.push_back({"deviation_m", std::sqrt(squares / count), 4});
  fields.push_back({"median_m", mcl_eval::quantile(error.metres, 0.5), 4});
  fields.push_back({"p95_m", mcl_eval::quantile(error.metres, 0.95), 4});
  fields.push_back({"max_m", mcl_eval::quantile(error.metres, 1), 4});
  fields.push_back({"mean_deg", mcl_eval::mean(error.degrees), 3});
}

Exit make(const Wanted& wanted) {
  const Input input = read_input(wanted);
  for (const std::string& remark : input.drive.remarks)
    fmt::print(stderr, "map-maker: {}: {}\n", wanted.log, remark);
  announce(wanted, input.drive);
  auto made = [&] {
    ProgressLine progress(wanted.quiet || wanted.json);
    return mapping::make_map(input.drive, wanted.settings, std::ref(progress));
  }();
  if (!made && made.error() == tims::Errc::kClosed) return Exit::kInterrupted;
  const MadeMap map = well(std::move(made), wanted.log);
  const auto laser = laser_poses(input.drive, map);
  auto fields = fields_of(input, map);
  if (!wanted.truth.empty()) add_error(wanted, input, laser, fields);
  if (!wanted.poses.empty()) write_poses(wanted, input.drive, laser);
  write_map(wanted, map);
  const std::string picture = wanted.picture.empty()
                                  ? wanted.map.substr(0, wanted.map.size() - 5) + "-doubts.png"
                                  : wanted.picture;
  if (!wanted.picture.empty() || contradicts_itself(map)) write_picture(picture, map);
  warn(wanted, map, picture);
  mcl_eval::print_line(fields, wanted.json);
  return Exit::kDone;
}

constexpr const char* kAbout =
    "Build a map of a building from a recorded drive through it.\n\n"
    "LOG is a CARMEN log (.clf), or a recording of a Scan2d by DatalogRec; the latter requires\n"
    "--odometry, the recording of Odometry or Position of the same drive. Drive slowly, return to\n"
    "earlier places from time to time, and drive the route again at the end: loop closures "
    "correct\n"
    "the map. The output is MAP.yaml and MAP.pgm (or .png) for ROS and MonteCarloLocalisation.";
constexpr const char* kExits =
    "Exit status: 0 done, 1 a file is invalid (FILE: line N: reason), 2 wrong command line, 4 no "
    "such\n"
    "file, 5 not written, 130 Ctrl-C: nothing was written.";

void add_options(timsctl::ArgumentParser& parser, Wanted& wanted) {
  parser.required_argument("LOG", wanted.log, "CARMEN log, or recording of a Scan2d");
  parser.required_argument("MAP", wanted.map, "output file, .yaml");
  parser.option("--odometry", wanted.odometry, "recording of Odometry or Position");
  parser.option("--resolution", wanted.resolution, "cell size [m]", {0.01, 1.0});
  parser.option("--range", wanted.range, "longest beams that are drawn [m]", {1.0, 1000.0});
  parser.option("--rounds", wanted.settings.rounds,
                "number of rounds of matching all scans with all others", {0, 20});
  parser.option("--lag", wanted.lag,
                "age of scans in a CARMEN log [s] (default: estimated from turns)", {-10.0, 10.0});
  parser.option("--image", wanted.image, "format of the image of the map: pgm or png");
  parser.option("--picture", wanted.picture,
                "write a picture (PNG) of the map and the drive, with walls that scans see through "
                "in red; a map with many of them is reported, and has MAP-doubts.png");
  parser.option("--poses", wanted.poses,
                "write the poses of the scanner, `time index x y theta`, in the form of mcl-eval");
  parser.option("--truth", wanted.truth,
                "compare the poses with true poses or relations, in the form of mcl-eval");
  parser.flag("--quiet", wanted.quiet, "do not print the progress");
  parser.flag("--json", wanted.json, "print the summary as a JSON object");
}

}  // namespace
}  // namespace rack::map_maker

int main(int argc, char** argv) {
  using namespace rack::map_maker;
  Wanted wanted;
  timsctl::ArgumentParser parser("map-maker", kAbout, kExits);
  add_options(parser, wanted);
  return parser.run(argc, argv, [&] {
    std::signal(SIGINT, [](int) { interrupted = true; });
    wanted.settings.resolution = 1000 * wanted.resolution;
    wanted.settings.range_max = 1000 * wanted.range;
    if (!wanted.map.ends_with(".yaml"))
      throw timsctl::usage_error(wanted.map + ": the map must be a .yaml file");
    if (!wanted.picture.empty() && !wanted.picture.ends_with(".png"))
      throw timsctl::usage_error(wanted.picture + ": the picture must be a .png file");
    if (wanted.image != "pgm" && wanted.image != "png")
      throw timsctl::usage_error("--image " + wanted.image + ": the image is pgm or png");
    return make(wanted);
  });
}

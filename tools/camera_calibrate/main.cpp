// camera-calibrate: the intrinsics of a camera from pictures of a board, or from a living Camera.
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "components/files/whole_file.h"
#include "os/clock.h"
#include "tools/camera_calibrate/calibrate.h"
#include "tools/camera_calibrate/collect.h"
#include "tools/camera_calibrate/residual_picture.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/output.h"

namespace rack::camera_calibrate {
namespace {

namespace json = timsctl::json;
using timsctl::Exit;
using timsctl::Failure;

struct Wanted {
  std::vector<std::string> pictures;
  std::string camera;
  std::string host;
  std::string board = "chessboard";
  std::string size = "9x6";
  double square = 25;   // mm
  double timeout = 5;   // s
  double duration = 0;  // s
  std::uint32_t views = 20;
  std::string save;
  std::string output = "calibration.yaml";
  std::string residuals;
  std::string name = "camera";
  CalibrationSettings settings{};
  bool json = false;
  bool quiet = false;
};

// --- the result as text and as JSON

std::string lens_text(const std::vector<double>& lens) {
  return fmt::format("k1 {:.5f}  k2 {:.5f}  p1 {:.6f}  p2 {:.6f}  k3 {:.5f}", lens.at(0),
                     lens.at(1), lens.at(2), lens.at(3), lens.at(4));
}

void print_text(const Wanted& wanted, const Calibrated& made) {
  const auto& camera = made.calibration.camera;
  const auto& deviation = made.uncertainty;
  fmt::print("{}: error {:.3f} pixels, {} views of {}x{} pixels\n", wanted.output, made.error,
             made.views.size(), made.calibration.width, made.calibration.height);
  fmt::print(
      "  fx {:.2f} +- {:.2f}  fy {:.2f} +- {:.2f}  cx {:.2f} +- {:.2f}  cy {:.2f} +- {:.2f}\n",
      camera.fx, deviation.fx, camera.fy, deviation.fy, camera.cx, deviation.cx, camera.cy,
      deviation.cy);
  fmt::print("  {}\n", lens_text(made.calibration.distortion));
  fmt::print("  seen in {:.0f} % of the picture\n", 100 * made.covered);
  std::size_t number = 0;
  for (const CalibratedView& view : made.views)
    fmt::print("  {:3}  {:.3f} pixels  {}{}\n", ++number, view.error, view.name,
               view.is_outlier ? "  (outlier)" : "");
}

void print_json(const Wanted& wanted, const CollectedViews& collected, const Calibrated& made) {
  const auto matrix = [](const pictures::CameraMatrix& camera) {
    return json::object{{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}};
  };
  json::array views;
  for (const CalibratedView& view : made.views)
    views.push_back(json::object{
        {"name", view.name}, {"error_pixels", view.error}, {"is_outlier", view.is_outlier}});
  const auto& lens = made.calibration.distortion;
  json::object result{{"output", wanted.output},
                      {"width", made.calibration.width},
                      {"height", made.calibration.height},
                      {"error_pixels", made.error},
                      {"camera", matrix(made.calibration.camera)},
                      {"deviations", matrix(made.uncertainty)},
                      {"rectified", matrix(made.calibration.rectified)},
                      {"distortion", json::array(lens.begin(), lens.end())},
                      {"covered", made.covered},
                      {"views", std::move(views)},
                      {"without_board",
                       json::array(collected.without_board.begin(), collected.without_board.end())},
                      {"warnings", json::array(made.warnings.begin(), made.warnings.end())}};
  fmt::print("{}\n", timsctl::to_text(std::move(result)));
}

// --- the program

tims::Duration duration_of(double seconds) {
  return std::chrono::duration_cast<tims::Duration>(std::chrono::duration<double>(seconds));
}

void write_result(const std::string& file, std::string_view contents) {
  if (const auto written = rack::write_file(file, contents); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
}

CollectedViews collect(const Wanted& wanted, const Board& board, const timsctl::Signals& signals) {
  CollectProgress progress(wanted.quiet || wanted.json);
  if (wanted.camera.empty()) return views_of_files(wanted.pictures, board, signals, progress);
  const LiveCollection live{.camera = wanted.camera,
                            .host = wanted.host,
                            .timeout = duration_of(wanted.timeout),
                            .views = wanted.views,
                            .duration = duration_of(wanted.duration),
                            .folder = wanted.save};
  return views_of_camera(live, board, signals, progress);
}

void check_found(const CollectedViews& collected, const Board& board) {
  if (!collected.views.empty()) return;
  throw Failure(
      Exit::kNo, "no_board",
      fmt::format("none of the {} pictures shows the whole {} of {}x{}",
                  collected.without_board.size(), name_of(board.kind), board.columns, board.rows),
      "--size counts the inner corners of a chessboard, or the circles; the board needs a "
      "white margin");
}

std::string remark_of(const Wanted& wanted, const Board& board, const Calibrated& made) {
  return fmt::format(
      "camera-calibrate: {} views, {} {}x{}, {:g} mm\n"
      "error {:.3f} pixels; standard deviations: fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f} pixels",
      made.views.size(), name_of(board.kind), board.columns, board.rows, wanted.square, made.error,
      made.uncertainty.fx, made.uncertainty.fy, made.uncertainty.cx, made.uncertainty.cy);
}

Exit run(const Wanted& wanted, const timsctl::Signals& signals) {
  const auto board = parse_board(wanted.board, wanted.size, wanted.square);
  if (!board) throw timsctl::usage_error(board.error().detail());
  if (!pictures::is_camera_name(wanted.name))
    throw timsctl::usage_error("--name must be at most 100 ASCII characters");
  const CollectedViews collected = collect(wanted, *board, signals);
  check_found(collected, *board);
  auto made =
      calibrate(collected.views, *board, collected.width, collected.height, wanted.settings);
  if (!made) throw Failure(Exit::kNo, "not_calibrated", made.error().detail());
  made->calibration.name = wanted.name;
  signals.sleep_until(tims::os::now());  // Ctrl-C: nothing is written
  if (!wanted.residuals.empty())
    write_result(wanted.residuals, timsctl::value_or_fail(draw_residuals(*made), wanted.residuals));
  write_result(wanted.output, to_yaml(made->calibration, remark_of(wanted, *board, *made)));
  if (wanted.json) {
    print_json(wanted, collected, *made);
  } else {
    print_text(wanted, *made);
  }
  for (const std::string& file : collected.without_board)
    if (!wanted.quiet)
      fmt::print(stderr, "camera-calibrate: {}: the whole board was not found\n", file);
  for (const std::string& warning : made->warnings)
    fmt::print(stderr, "camera-calibrate: warning: {}\n", warning);
  return Exit::kDone;
}

constexpr const char* kAbout =
    "Determine the intrinsics of a camera from pictures of a board.\n\n"
    "PICTURES are files (PNG, PGM, JPEG) or folders; with --camera, views are collected from a\n"
    "running Camera until there are enough different ones. Hold the board in all parts of the\n"
    "picture, tilted by 20 to 45 degrees in different directions, 15 to 30 times; a board for a\n"
    "screen or paper must be flat. The output is a YAML file of ROS, for calibration= of "
    "CameraV4l.";
constexpr const char* kExits =
    "Exit status: 0 done, 1 the pictures do not determine the camera, or one is invalid, 2 wrong\n"
    "command line, 3 no router, 4 no such file or component, 5 not written, 6 no answer or too "
    "few\n"
    "views in time, 130 Ctrl-C: nothing was written.";

void add_options(timsctl::ArgumentParser& parser, Wanted& wanted) {
  parser.arguments("PICTURES", wanted.pictures, "files, or folders with pictures");
  parser.option("--camera", wanted.camera, "collect views from this component, e.g. Camera/0/0");
  parser.option("--host,-H", wanted.host, "router of --camera (default: that of this host)");
  parser.option("--board", wanted.board, "chessboard, circles or asymmetric-circles");
  parser.option("--size", wanted.size, "inner corners of the chessboard, or circles: COLUMNSxROWS");
  parser.option("--square", wanted.square,
                "side of a square, or distance of circles (asymmetric: of their rows) [mm]",
                {0.001, 100000.0});
  parser.option("--output", wanted.output, "file of the calibration");
  parser.option("--residuals", wanted.residuals, "draw the residuals to this file (PNG)");
  parser.option("--name", wanted.name, "camera_name in the file");
  parser.flag("--k3", wanted.settings.has_k3, "also determine k3: for wide lenses");
  parser.option("--keep", wanted.settings.keep,
                "rectified pictures: 0 without border, 1 with all pixels of the camera",
                {0.0, 1.0});
  parser.option("--views", wanted.views, "views to collect from --camera", {6.0, 250.0});
  parser.option("--duration", wanted.duration, "stop collecting after this time [s]; 0: never",
                {0.0, 86400.0});
  parser.option("--save", wanted.save, "write the pictures of collected views to this folder");
  parser.option("--timeout", wanted.timeout, "time for an answer of --camera [s]", {0.1, 600.0});
  parser.flag("--quiet", wanted.quiet, "do not print the progress");
  parser.flag("--json", wanted.json, "print the result as a JSON object");
}

}  // namespace
}  // namespace rack::camera_calibrate

int main(int argc, char** argv) {
  using namespace rack::camera_calibrate;
  Wanted wanted;
  timsctl::ArgumentParser parser("camera-calibrate", kAbout, kExits);
  add_options(parser, wanted);
  const timsctl::Signals signals;  // before any thread
  return parser.run(argc, argv, [&] {
    if (wanted.pictures.empty() == wanted.camera.empty())
      throw timsctl::usage_error("name pictures, or a camera with --camera",
                                 "`camera-calibrate --help`");
    return run(wanted, signals);
  });
}

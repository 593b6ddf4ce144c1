// camera-calibrate as a real program: pictures in a folder, a living camera, Ctrl-C, errors. And
// CameraV4l with the file that it has written.
#include <filesystem>
#include <fstream>

#include <boost/json.hpp>
#include <gmock/gmock.h>

#include "components/pictures/camera_calibration.h"
#include "os/file.h"
#include "tests/support/eventually.h"
#include "tests/support/rendered_board.h"
#include "tests/system/camera_fixture.h"

namespace tims::test {
namespace camera_calibrate_test {

namespace fs = std::filesystem;
namespace video = rack::device::video;
using rack::camera_calibrate::Board;
using rack::camera_calibrate::BoardKind;
using rack::pictures::CameraCalibration;
using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr Board kBoard{.kind = BoardKind::kChessboard, .columns = 7, .rows = 5, .square = 30};

const RenderedCamera& lens() {
  static const RenderedCamera camera({.width = kWidth,
                                      .height = kHeight,
                                      .camera = {.fx = 262, .fy = 258, .cx = 166, .cy = 114},
                                      .distortion = {-0.3, 0.1, 0, 0, 0},
                                      .rectified = {}});
  return camera;
}

const std::vector<Bytes>& views() {
  static const std::vector<Bytes> all = [] {
    std::vector<Bytes> pictures;
    for (const BoardPose& pose : lens().poses(kBoard, 20, 0.6))
      pictures.push_back(lens().render(
          kBoard, pose, {.noise = 2, .seed = static_cast<std::uint32_t>(pictures.size())}));
    return pictures;
  }();
  return all;
}

void expect_lens(const CameraCalibration& found) {
  const auto& truth = lens().calibration();
  EXPECT_EQ(found.width, kWidth);
  EXPECT_NEAR(found.camera.fx, truth.camera.fx, 0.005 * truth.camera.fx);
  EXPECT_NEAR(found.camera.fy, truth.camera.fy, 0.005 * truth.camera.fy);
  EXPECT_NEAR(found.camera.cx, truth.camera.cx, 1);
  EXPECT_NEAR(found.camera.cy, truth.camera.cy, 1);
  EXPECT_NEAR(found.distortion.at(0), truth.distortion.at(0), 0.02);
  EXPECT_NEAR(found.distortion.at(1), truth.distortion.at(1), 0.05);
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

class CameraCalibrateTest : public CameraTest {
 protected:
  struct Run {
    int status = -1;
    std::string out;
    std::string err;
  };

  ChildProcess begin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(TIMS_PROGRAMS) + "/camera-calibrate");
    ChildOptions options = at_router();
    options.folder = folder_.path();
    auto child = ChildProcess::start(std::move(arguments), options);
    EXPECT_TRUE(child) << child.error().message();
    return std::move(child).value();
  }
  Run calibrate(std::vector<std::string> arguments) {
    ChildProcess child = begin(std::move(arguments));
    const auto status = child.wait(2 * kPatience);
    EXPECT_TRUE(status) << status.error().message();
    return {status ? status->code : -1, child.standard_output(), child.standard_error()};
  }
  std::string file(const std::string& name) const { return folder_.path() / name; }

  void write_views(const std::string& folder, std::size_t count) {
    fs::create_directories(file(folder));
    for (std::size_t i = 0; i < count; ++i)
      write(folder_.path() / folder / ("view" + std::to_string(100 + i) + ".pgm"),
            pgm_of(views().at(i), kWidth, kHeight));
  }

  // Each picture `times` times.
  std::string recording(const std::vector<Bytes>& pictures, int times) {
    Recording all;
    all.head({video::kGrey, kWidth, kHeight, kWidth}, 40ms);
    for (const Bytes& picture : pictures)
      for (int i = 0; i < times; ++i) all.add(video::kGrey, picture, 40ms);
    return play(all, "?loop=1");
  }
};

const std::vector<std::string> kBoardOptions = {"--size", "7x5", "--square", "30"};

std::vector<std::string> with_board(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), kBoardOptions.begin(), kBoardOptions.end());
  return arguments;
}

TEST_F(CameraCalibrateTest, CalibratesByAFolderOfPictures) {
  write_views("views", 20);
  write(folder_.path() / "views" / "notes.txt", "not a picture");
  write(folder_.path() / "views" / "zz.pgm",
        pgm_of(Bytes(std::size_t{kWidth} * kHeight), kWidth, kHeight));
  const Run text = calibrate(with_board(
      {"views", "--output", "lens.yaml", "--residuals", "residuals.png", "--name", "front"}));
  ASSERT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("lens.yaml: error 0."));
  EXPECT_THAT(text.out, HasSubstr("20 views of 320x240 pixels"));
  EXPECT_THAT(text.out, HasSubstr("views/view119.pgm"));
  EXPECT_THAT(text.err, HasSubstr("views/zz.pgm: the whole board was not found"));
  const auto written = rack::pictures::read_calibration(*os::read_file(file("lens.yaml")));
  ASSERT_TRUE(written) << written.error().detail();
  expect_lens(*written);
  EXPECT_EQ(written->name, "front");
  EXPECT_TRUE(os::read_file(file("residuals.png"))->starts_with("\x89PNG"));

  const Run json = calibrate(with_board({"views", "--json"}));
  ASSERT_EQ(json.status, 0) << json.err;
  const auto result = boost::json::parse(json.out).as_object();
  EXPECT_LT(result.at("error_pixels").as_double(), 0.2);
  EXPECT_EQ(result.at("views").as_array().size(), 20U);
  EXPECT_EQ(result.at("without_board").as_array().size(), 1U);
  EXPECT_NEAR(result.at("camera").at("fx").as_double(), written->camera.fx, 1e-3);
  EXPECT_TRUE(fs::exists(file("calibration.yaml")));
}

TEST_F(CameraCalibrateTest, CameraV4lRectifiesByTheFile) {
  write_views("views", 20);
  ASSERT_EQ(calibrate(with_board({"views"})).status, 0);
  const auto made = *rack::pictures::read_calibration(*os::read_file(file("calibration.yaml")));
  // An upright edge, dark to the left, at the side of the picture.
  constexpr double kEdge = -0.4;
  const Bytes seen = lens().render([](double x, double) { return x < kEdge ? 0.1 : 0.9; });
  const auto edge_in = [](std::span<const std::byte> pixels, std::size_t row) {
    std::size_t x = 0;
    while (x < kWidth && std::to_integer<int>(pixels[row * kWidth + x]) < 128) ++x;
    return static_cast<double>(x);
  };
  EXPECT_GT(std::abs(edge_in(seen, 10) - edge_in(seen, 120)), 3);
  start("CameraV4l",
        {recording({seen}, 5), "--mode=mono8", "--calibration=" + file("calibration.yaml")});
  // Read when it is turned on.
  EXPECT_THAT(camera().get_parameter().error().message(), HasSubstr("turned on"));
  const auto on = camera().on();
  ASSERT_TRUE(on) << on.error().message();
  const auto picture = camera().get_next_data(kPatience);
  ASSERT_TRUE(picture) << picture.error().message();
  ASSERT_EQ(picture->image.size(), std::size_t{kWidth} * kHeight);
  const double expected = made.rectified.fx * kEdge + made.rectified.cx + 0.5;
  for (const std::size_t row : {5U, 60U, 120U, 180U, 235U})
    EXPECT_NEAR(edge_in(picture->image, row), expected, 1.5) << row;
  const auto parameter = camera().get_parameter();
  ASSERT_TRUE(parameter);
  EXPECT_EQ(parameter->calibration_width, kWidth);
  EXPECT_NEAR(parameter->fx.raw(), made.rectified.fx, 0.01);
  EXPECT_NEAR(parameter->n0.raw(), made.rectified.cy, 0.01);

  // The picture is compressed again after it was rectified. Depths cannot be rectified.
  ASSERT_TRUE(camera().set_format({.width = -1, .height = -1, .depth = -1, .mode = 41}));
  EXPECT_TRUE(eventually([&] { return camera().get_next_data(kPatience)->mode == 41; }, "jpeg"));
  EXPECT_THAT(
      camera().set_format({.width = -1, .height = -1, .depth = -1, .mode = 51}).error().message(),
      HasSubstr("mode range is not rectified"));
  // Its pictures are no longer those of the lens.
  const Run again = calibrate(with_board({"--camera", "Camera/0/0"}));
  EXPECT_EQ(again.status, 1);
  EXPECT_THAT(again.err, HasSubstr("Camera/0/0 rectifies its pictures already"));
}

TEST_F(CameraCalibrateTest, CameraV4lReportsWhatContradicts) {
  write_views("views", 20);
  ASSERT_EQ(calibrate(with_board({"views"})).status, 0);
  const std::string calibration = "--calibration=" + file("calibration.yaml");
  write(folder_.path() / "broken.yaml", "image_width: none\n");
  const std::string device = recording({views().front()}, 5);
  struct Case {
    std::vector<std::string> options;
    const char* reason;
  };
  for (const Case& one :
       {Case{{"--calibration=" + file("missing.yaml")}, "missing.yaml: No such file"},
        Case{{"--calibration=" + file("broken.yaml")}, "broken.yaml: line 1: image_width"},
        Case{{calibration, "--fx=500"}, "fx=500 contradicts the calibration"},
        Case{{calibration, "--fx=200", "--height=180"}, "another aspect ratio"},
        Case{{calibration, "--mode=range"}, "mode range is not rectified"},
        Case{{calibration, "--stereoBase=60"}, "stereo camera are not rectified"}}) {
    std::vector<std::string> options = {device, "--mode=mono8"};
    options.insert(options.end(), one.options.begin(), one.options.end());
    start("CameraV4l", options);
    const auto on = camera().on();
    ASSERT_FALSE(on) << one.reason;
    EXPECT_THAT(on.error().message(), HasSubstr(one.reason));
    kill("CameraV4l");
  }
  // Pictures of another aspect ratio than the calibration.
  std::string text = *os::read_file(file("calibration.yaml"));
  text.replace(text.find("image_height: 240"), 17, "image_height: 180");
  write(folder_.path() / "wide.yaml", text);
  start("CameraV4l", {device, "--mode=mono8", "--calibration=" + file("wide.yaml")});
  const auto on = camera().on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), HasSubstr("320x180 pixels, those of the camera have 320x240"));
}

TEST_F(CameraCalibrateTest, CollectsViewsOfALivingCamera) {
  start("CameraV4l", {recording(views(), 4), "--mode=mono8"});
  const Run off = calibrate(with_board({"--camera", "Camera/0/0"}));
  EXPECT_EQ(off.status, 1);
  EXPECT_THAT(off.err, HasSubstr("turn it on: timsctl component on Camera/0/0"));
  ASSERT_TRUE(camera().on());
  const Run run =
      calibrate(with_board({"--camera", "Camera/0/0", "--views", "12", "--save", "saved"}));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("1 of 12 views; taken; "));
  EXPECT_THAT(run.err, HasSubstr(" more to do)"));
  const auto written = rack::pictures::read_calibration(*os::read_file(file("calibration.yaml")));
  ASSERT_TRUE(written);
  expect_lens(*written);
  // The saved pictures give the same again.
  const Run again = calibrate(with_board({"saved", "--output", "again.yaml"}));
  ASSERT_EQ(again.status, 0) << again.err;
  const auto repeated = rack::pictures::read_calibration(*os::read_file(file("again.yaml")));
  EXPECT_NEAR(repeated->camera.fx, written->camera.fx, 1e-6);
}

TEST_F(CameraCalibrateTest, TheCameraMayBeElsewhere) {
  start("CameraV4l", {recording(views(), 4), "--mode=jpeg", "--quality=95"});
  ASSERT_TRUE(camera().on());
  const Run run = calibrate(with_board(
      {"--camera", "Camera/0/0", "--views", "8", "--host", router_.tcp(), "--duration", "30"}));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(fs::exists(file("calibration.yaml")));
}

TEST_F(CameraCalibrateTest, NothingIsWrittenAfterCtrlC) {
  start("CameraV4l", {recording({views().front()}, 5), "--mode=mono8"});
  ASSERT_TRUE(camera().on());
  write(folder_.path() / "calibration.yaml", "the old one");
  ChildProcess child = begin(with_board({"--camera", "Camera/0/0", "--residuals", "r.png"}));
  ASSERT_TRUE(child.wait_for_line("1 of 20 views; taken"));
  const auto status = child.stop(SIGINT);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->code, 130);
  EXPECT_EQ(*os::read_file(file("calibration.yaml")), "the old one");
  EXPECT_FALSE(fs::exists(file("r.png")));
  // The same view again and again is one view.
  const Run timed = calibrate(with_board({"--camera", "Camera/0/0", "--duration", "1"}));
  EXPECT_EQ(timed.status, 6);
  EXPECT_THAT(timed.err, HasSubstr("1 views of the board in this time; at least 6 are needed"));
}

TEST_F(CameraCalibrateTest, ErrorsStateWhatToDo) {
  write_views("few", 5);
  write_views("views", 6);
  fs::create_directories(file("empty"));
  fs::create_directories(file("blank"));
  write(folder_.path() / "blank" / "a.pgm",
        pgm_of(Bytes(std::size_t{kWidth} * kHeight), kWidth, kHeight));
  write(folder_.path() / "small.pgm", pgm_of(Bytes(100), 10, 10));
  write(folder_.path() / "broken.png", "not a picture");
  struct Case {
    std::vector<std::string> arguments;
    int status;
    const char* reason;
  };
  for (const Case& one :
       {Case{with_board({"few"}), 1, "5 views of the board; at least 6 are needed"},
        Case{with_board({"blank"}), 1, "none of the 1 pictures shows the whole chessboard of 7x5"},
        Case{{"views", "--size", "8x5"}, 1, "--size counts the inner corners"},
        Case{with_board({"views", "small.pgm"}), 1, "small.pgm has 10x10 pixels"},
        Case{with_board({"broken.png"}), 1, "broken.png: not a PNG, PGM or JPEG picture"},
        Case{with_board({"missing.png"}), 4, "missing.png"},
        Case{with_board({"empty"}), 4, "no pictures"}, Case{{}, 2, "name pictures, or a camera"},
        Case{{"views", "--camera", "Camera/0/0"}, 2, "name pictures, or a camera"},
        Case{{"views", "--size", "9"}, 2, "COLUMNSxROWS"},
        Case{{"views", "--board", "dots"}, 2, "--board must be"},
        Case{{"views", "--name", "Kam\xC3\xA9ra"}, 2, "--name"},
        Case{{"--camera", "Ladar/0/0"}, 2, "is not a Camera"},
        Case{{"--camera", "Camera/0/0"}, 4, "Camera(0/0)"},
        Case{{"--camera", "Camera/0/0", "-H", "/nowhere.sock"}, 3, "no router"},
        Case{with_board({"views", "--output", "missing/c.yaml"}), 5, "missing/c.yaml"}}) {
    const Run run = calibrate(one.arguments);
    EXPECT_EQ(run.status, one.status) << one.reason << "\n" << run.err;
    EXPECT_THAT(run.err, HasSubstr(one.reason));
    EXPECT_EQ(run.out, "");
    EXPECT_FALSE(fs::exists(file("calibration.yaml")));
  }
}

}  // namespace camera_calibrate_test
}  // namespace tims::test

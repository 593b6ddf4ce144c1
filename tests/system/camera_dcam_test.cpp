// CameraDcam as a real program, with a stand-in behind the calls of libdc1394
// (tests/support/dc1394_stand_in.cpp): its modes, exposure and white balance, calibration, what
// happens when the camera is unplugged, hangs, or sends corrupt frames.
#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>

#include "tests/support/dc1394_scene.h"
#include "tests/support/eventually.h"
#include "tests/system/camera_fixture.h"

namespace tims::test {
namespace camera_dcam_test {

namespace camera_mode = rack::camera_mode;
using rack::CameraData;
using rack::u16;
using testing::HasSubstr;

class CameraDcamTest : public CameraTest, protected Dc1394Scene {
 protected:
  void SetUp() override {
    CameraTest::SetUp();
    // For programs of this test; the test itself does not call the library.
    ::setenv("LD_LIBRARY_PATH", DC1394_STAND_IN_FOLDER, 1);  // NOLINT(concurrency-mt-unsafe)
  }
  void TearDown() override { ::unsetenv("LD_LIBRARY_PATH"); }  // NOLINT(concurrency-mt-unsafe)

  void start_small(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"--width=640", "--height=480", "--fps=30"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    start("CameraDcam", arguments);
  }
  std::string why_not_on() {
    const auto on = camera().on();
    return on ? "on" : on.error().message();
  }
  static int at(const CameraData& picture, std::size_t i) {
    return i < picture.image.size() ? std::to_integer<int>(picture.image[i]) : -1;
  }
};

struct Mode {
  const char* name;
  u16 number;
  u16 depth;
  rack::u32 filter;
};
void PrintTo(const Mode& mode, std::ostream* out) { *out << mode.name; }

class DcamModesTest : public CameraDcamTest, public testing::WithParamInterface<Mode> {};

TEST_P(DcamModesTest, IsPublished) {
  const Mode& one = GetParam();
  start_small({std::string("--mode=") + one.name, "--autoBrightnessSize=0"});
  ASSERT_EQ(why_not_on(), "on");
  const CameraData picture = next_picture();
  EXPECT_EQ(picture.mode, one.number);
  EXPECT_EQ(picture.depth, one.depth);
  EXPECT_EQ(picture.width, 640);
  EXPECT_EQ(picture.height, 480);
  if (one.number == camera_mode::kJpeg) {
    EXPECT_EQ(picture.colorFilterId, picture.image.size());
    EXPECT_EQ(at(picture, 0), 0xFF);
    return;
  }
  EXPECT_EQ(picture.colorFilterId, one.filter);
  ASSERT_EQ(picture.image.size(), 640U * 480 * one.depth / 8);
  // The ramp rises to the right: compare the second byte of the first and the last group of pixels.
  const std::size_t pixel = one.depth / 8;
  const std::size_t byte = one.depth == 16 && one.number != camera_mode::kYuv422 ? 0 : 1;
  EXPECT_LT(at(picture, byte), at(picture, 638 * pixel + byte));
}

INSTANTIATE_TEST_SUITE_P(All, DcamModesTest,
                         testing::Values(Mode{"mono8", 1, 8, 0}, Mode{"mono12", 2, 16, 0},
                                         Mode{"mono16", 3, 16, 0}, Mode{"rgb24", 11, 24, 0},
                                         Mode{"yuv422", 21, 16, 0}, Mode{"raw8", 31, 8, 512},
                                         Mode{"raw12", 32, 16, 512}, Mode{"raw16", 33, 16, 512},
                                         Mode{"jpeg", 41, 24, 0}),
                         [](const auto& one) { return std::string(one.param.name); });

// Parameters of a start script of the original: its defaults are for a camera of 1280x960.
TEST_F(CameraDcamTest, ItStartsWithTheParametersOfTheOriginal) {
  std::ofstream(folder_.path() / "intrinsic_lr2.cal")
      << "f 8.5\nfx 812.5\nfy 813\nk1 -0.0015\ncalibration_width 640\ncalibration_height 480\n";
  std::ofstream(folder_.path() / "extrinsic.cal") << "r1 0\nr2 1\nt3 250\n";
  start("CameraDcam",
        {"--cameraGuid=10597059", "--mode=yuv422", "--fps=10", "--lossrate=2", "--uValue=150",
         "--vValue=120", "--whitebalanceMode=1", "--whitebalanceCols=20", "--whitebalanceRows=10",
         "--minHue=60", "--maxHue=250", "--gainMult=16", "--shutterMult=64",
         "--autoBrightnessSize=1", "--intrParFile=" + std::string(folder_.path() / "intrinsic"),
         "--extrParFile=" + std::string(folder_.path() / "extrinsic")});
  ASSERT_EQ(why_not_on(), "on");
  const CameraData picture = next_picture();
  EXPECT_EQ(picture.mode, camera_mode::kYuv422);
  EXPECT_EQ(picture.width, 640);
  EXPECT_EQ(picture.height, 480);
  const auto parameters = camera().get_parameter();
  ASSERT_TRUE(parameters);
  EXPECT_EQ(parameters->fx, 812.5F);
  EXPECT_EQ(parameters->k1, -0.0015F);
  EXPECT_EQ(parameters->calibration_width, 640);
  EXPECT_EQ(parameters->coordinateRotation[1], 1);
  EXPECT_EQ(parameters->coordinateTranslation[2], 250.0F);
}

TEST_F(CameraDcamTest, ExposureAndWhiteBalanceAreControlledByThePictures) {
  scene("light", 20);
  start_small({"--shutterMult=3000", "--gainMult=500"});
  ASSERT_EQ(why_not_on(), "on");
  // Dark pixels end when the darkest part of the ramp is above minHue, or bright ones begin.
  EXPECT_TRUE(eventually([&] { return state("shutter") > 3000; }, "an open shutter"));
  EXPECT_EQ(state("autoshutter"), 0);
  EXPECT_EQ(state("autowhite"), 0);
  const auto is_near = [&](const char* name, int value) {
    return std::abs(state(name) - value) < 4;
  };
  EXPECT_TRUE(eventually([&] { return is_near("blue", 132) && is_near("red", 118); }, "grey"));
  scene("light", 300);
  EXPECT_TRUE(eventually([&] { return state("shutter") < 1200; }, "a shorter shutter"));
  EXPECT_TRUE(eventually([&] { return state("gain") == 192; }, "the least gain"));
}

TEST_F(CameraDcamTest, ControlsAreFixedOrTheCameras) {
  start_small({"--autoBrightnessSize=0", "--shutter=777", "--whitebalanceMode=0", "--uValue=99"});
  ASSERT_EQ(why_not_on(), "on");
  next_picture();
  EXPECT_EQ(state("shutter"), 777);
  EXPECT_EQ(state("autoshutter"), 0);
  EXPECT_EQ(state("autogain"), 1);
  EXPECT_EQ(state("blue"), 99);
  EXPECT_EQ(state("red"), 120);
  ASSERT_TRUE(camera().off());
  EXPECT_TRUE(eventually([&] { return state("sending") == 0; }, "a camera that was stopped"));
}

TEST_F(CameraDcamTest, AnUnpluggedOrHangingCameraComesBack) {
  start_small({"--errorTimeout=50"});
  ASSERT_EQ(why_not_on(), "on");
  next_picture();
  for (const auto& [fault, bad, good] : {std::tuple{"plugged", 0, 1}, std::tuple{"hang", 1, 0},
                                         std::tuple{"broken", 1, 0}, std::tuple{"corrupt", 1, 0}}) {
    scene(fault, bad);
    EXPECT_TRUE(eventually([&] { return has_status(rack::Status::kError); }, fault));
    scene(fault, good);
    EXPECT_TRUE(eventually([&] { return has_status(rack::Status::kEnabled); }, fault));
    next_picture();
  }
  // Some corrupt frames are normal.
  scene("corrupt", 3);
  for (int i = 0; i < 5; ++i) next_picture();
  EXPECT_TRUE(has_status(rack::Status::kEnabled));
}

TEST_F(CameraDcamTest, TheFormatIsSetWhileItIsOn) {
  start_small({"--mode=mono8"});
  ASSERT_EQ(why_not_on(), "on");
  EXPECT_EQ(next_picture().width, 640);
  ASSERT_TRUE(camera().set_format({.width = 160, .height = -1, .depth = -1, .mode = -1}));
  EXPECT_TRUE(eventually([&] { return next_picture().width == 160; }, "every fourth pixel"));
  ASSERT_TRUE(camera().set_format({.width = -1, .height = -1, .depth = 24, .mode = 11}));
  EXPECT_TRUE(eventually([&] { return next_picture().mode == camera_mode::kRgb24; }, "rgb24"));
  EXPECT_EQ(next_picture().height, 120);
  for (const rack::CameraFormatData& wrong : {rack::CameraFormatData{641, -1, -1, -1},
                                              {37, -1, -1, -1},
                                              {640, -1, -1, 51},
                                              {640, -1, 8, 11},
                                              {640, -1, -1, 99}})
    EXPECT_FALSE(camera().set_format(wrong)) << wrong.mode;
  EXPECT_EQ(next_picture().mode, camera_mode::kRgb24);
  scene("small", 1);  // now without scalable modes
  const auto refused = camera().set_format({.width = -1, .height = -1, .depth = -1, .mode = 31});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("it has: 320x240 UYVY"));
}

TEST_F(CameraDcamTest, WhatIsWrongIsReported) {
  scene("small", 1);
  start("CameraDcam");
  EXPECT_THAT(why_not_on(), HasSubstr("does not send 1280x960 as UYVY, YUYV, MJPG, JPEG; it has: "
                                      "320x240 UYVY, 640x480 YUV411, 640x480 UYVY"));
  kill("CameraDcam");
  struct Case {
    const char* parameter;
    const char* reason;
  };
  for (const Case& one :
       {Case{"--mode=range", "mode must be mono8"},
        Case{"--cameraGuid=first", "cameraGuid must be 0"},
        Case{"--cameraGuid=7", "IIDC camera 00000007 is not there; there are:"},
        Case{"--isoSpeed=300", "speed must be 100"}, Case{"--isoSpeed=800", "not capable of 1394B"},
        Case{"--intrParFile=/none", "intrParFile: /none_lr1.cal"},
        Case{"--extrParFile=/none", "extrParFile: /none.cal"}}) {
    start_small({one.parameter});
    EXPECT_THAT(why_not_on(), HasSubstr(one.reason)) << one.parameter;
    kill("CameraDcam");
  }
  std::ofstream(folder_.path() / "other_lr1.cal") << "calibration_width 1280\n";
  start_small({"--intrParFile=" + std::string(folder_.path() / "other")});
  EXPECT_THAT(why_not_on(), HasSubstr("for pictures of 1280x480 pixels, not 640x480"));
  kill("CameraDcam");
  std::ofstream(folder_.path() / "other_lr1.cal") << "fx 800\nfy nothing\n";
  start_small({"--intrParFile=" + std::string(folder_.path() / "other")});
  EXPECT_THAT(why_not_on(),
              HasSubstr("other_lr1.cal, line 2: \"fy\" must be followed by a number"));
  kill("CameraDcam");
  for (const auto& [name, value, reason] :
       {std::tuple{"full", 1, "the bus is full"}, std::tuple{"plugged", 0, "nor is any other"},
        std::tuple{"bus", 0, "no FireWire or USB bus"}}) {
    scene(name, value);
    start_small();
    EXPECT_THAT(why_not_on(), HasSubstr(reason));
    kill("CameraDcam");
  }
}

// What was recorded is played without the camera.
TEST_F(CameraDcamTest, ARecordingIsPlayedAndReplayed) {
  const std::string file = folder_.path() / "dcam.cap";
  const std::vector<std::string> format = {"--width=320", "--height=240", "--fps=30",
                                           "--lossrate=4"};
  const auto with = [&](const std::string& last) {
    auto all = format;
    all.push_back(last);
    return all;
  };
  auto& recorded = start("CameraDcam", with("--record=" + file));
  ASSERT_EQ(why_not_on(), "on");
  for (int i = 0; i < 3; ++i) next_picture();
  ASSERT_TRUE(recorded.stop(SIGTERM));  // which finishes the file
  scene("bus", 0);
  start("CameraDcam", with("--device=play:" + file + "?loop=1"));
  ASSERT_EQ(why_not_on(), "on");
  EXPECT_EQ(next_picture().width, 80);
  auto command = with("--replay=" + file);
  command.insert(command.begin(), std::string(TIMS_PROGRAMS) + "/CameraDcam");
  auto replay = ChildProcess::start(command);
  ASSERT_TRUE(replay);
  ASSERT_TRUE(replay->wait());
  EXPECT_THAT(replay->output(), HasSubstr(" replayed: 0 different"));
}

}  // namespace camera_dcam_test
}  // namespace tims::test

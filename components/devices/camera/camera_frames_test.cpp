#include "components/devices/camera/camera_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace camera_frames_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kBrightness = 0x00980900;  // V4L2_CID_BRIGHTNESS

class CameraFramesTest : public testing::Test, public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    EXPECT_EQ(id, kBrightness);
    value_ = 0;
    for (std::size_t i = bytes.size(); i-- > 0;)
      value_ = value_ << 8 | std::to_integer<int>(bytes[i]);
    ++sent_;
  }

 protected:
  void send_head(CameraFrames& camera, const VideoHead& head) {
    const auto bytes = bytes_of(head);
    camera.on_arrival({.bytes = bytes, .first = now_, .last = now_, .id = video::kHead}, *this);
  }
  bool give(CameraFrames& camera, std::uint32_t format, const std::vector<std::byte>& frame) {
    now_ += 10ms;
    camera.on_arrival({.bytes = frame, .first = now_, .last = now_, .id = format}, *this);
    return camera.take(picture_, recorded_);
  }

  Time now_{1000s};
  CameraData picture_;
  Time recorded_;
  int value_ = 0;
  int sent_ = 0;
};

TEST_F(CameraFramesTest, AFrameIsAPictureOfItsTime) {
  CameraFrames camera({.mode = camera_mode::kMono8});
  camera.start(now_, *this);
  send_head(camera, {video::kGrey, 4, 2, 4});
  ASSERT_TRUE(give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{77})));
  EXPECT_EQ(picture_.width, 4);
  EXPECT_EQ(picture_.image.size(), 8U);
  EXPECT_EQ(recorded_, now_);
  EXPECT_FALSE(camera.take(picture_, recorded_));
}

TEST_F(CameraFramesTest, PicturesThatComeTooFastAreLeftOut) {
  CameraFrames camera({.mode = camera_mode::kMono8, .period = 40ms});
  camera.start(now_, *this);
  send_head(camera, {video::kGrey, 4, 2, 4});
  int taken = 0;
  for (int i = 0; i < 100; ++i)
    taken += give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{77})) ? 1 : 0;
  EXPECT_NEAR(taken, 25, 1);
}

TEST_F(CameraFramesTest, DamagedFramesAreLeftOutUntilItIsNotTheCable) {
  CameraFrames camera({.mode = camera_mode::kMono8});
  camera.start(now_, *this);
  EXPECT_FALSE(give(camera, video::kGrey, std::vector<std::byte>(8)));  // before the header
  send_head(camera, {video::kGrey, 4, 2, 4});
  for (int i = 0; i < 29; ++i) EXPECT_FALSE(give(camera, video::kGrey, std::vector<std::byte>(7)));
  EXPECT_TRUE(camera.failure());
  EXPECT_EQ(camera.damaged(), 30U);
  camera.start(now_, *this);
  send_head(camera, {video::kGrey, 4, 2, 4});
  EXPECT_TRUE(give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{77})));
}

TEST_F(CameraFramesTest, ACameraWithoutPicturesIsReported) {
  CameraFrames camera({.mode = camera_mode::kMono8});
  camera.start(now_, *this);
  EXPECT_FALSE(camera.is_ready());
  EXPECT_EQ(camera.next_timeout(), now_ + 5s);
  camera.on_timeout(now_ + 5s, *this);
  ASSERT_TRUE(camera.failure());
  EXPECT_THAT(camera.failure()->detail(), testing::HasSubstr("5 s"));
  camera.start(now_, *this);
  send_head(camera, {video::kGrey, 4, 2, 4});
  ASSERT_TRUE(give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{77})));
  EXPECT_TRUE(camera.is_ready());
  EXPECT_EQ(camera.next_timeout(), tims::kNever);
}

TEST_F(CameraFramesTest, AFormatThatCannotBecomeTheModeIsReported) {
  CameraFrames camera({.mode = camera_mode::kRgb24});
  camera.start(now_, *this);
  send_head(camera, {video::kDepth16, 4, 2, 8});
  EXPECT_FALSE(give(camera, video::kDepth16, std::vector<std::byte>(16)));
  ASSERT_TRUE(camera.failure());
  EXPECT_THAT(camera.failure()->detail(), testing::HasSubstr("Z16"));
}

TEST_F(CameraFramesTest, ADarkPictureMakesItBrighterUntilItIsNot) {
  CameraFrames camera({.mode = camera_mode::kMono8});
  camera.start(now_, *this);
  const auto control = bytes_of(VideoControl{kBrightness, -64, 64, 0});
  camera.on_arrival({.bytes = control, .id = video::kControl}, *this);
  send_head(camera, {video::kGrey, 4, 2, 4});
  ASSERT_TRUE(give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{5})));
  EXPECT_EQ(sent_, 1);
  EXPECT_GT(value_, 0);
  const int first = value_;
  ASSERT_TRUE(give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{5})));
  EXPECT_GT(value_, first);
  ASSERT_TRUE(give(camera, video::kGrey, std::vector<std::byte>(8, std::byte{100})));
  EXPECT_EQ(sent_, 2);
}

TEST_F(CameraFramesTest, TwoEyesSeeHowFar) {
  CameraFrames camera({.mode = camera_mode::kRange,
                       .focal = 100,
                       .base = 60,
                       .stereo = {.disparities = 16, .block = 5}});
  camera.start(now_, *this);
  constexpr std::uint32_t kWidth = 40;
  constexpr std::uint32_t kHeight = 12;
  send_head(camera, {video::kGrey, 2 * kWidth, kHeight, 2 * kWidth});
  std::vector<std::byte> pair(std::size_t{2} * kWidth * kHeight);
  const auto texture = [](std::uint32_t x, std::uint32_t y) {
    return static_cast<std::byte>((x * 2654435761U ^ y * 40503U * 65537U) >> 24);
  };
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      pair[y * 2 * kWidth + x] = texture(x, y);
      pair[y * 2 * kWidth + kWidth + x] = texture(x + 6, y);
    }
  ASSERT_TRUE(give(camera, video::kGrey, pair));
  EXPECT_EQ(picture_.width, kWidth);
  EXPECT_EQ(picture_.depth, 16);
  EXPECT_EQ(picture_.mode, camera_mode::kRange);
  const std::size_t middle = std::size_t{2} * (6 * kWidth + 22);
  const int range = std::to_integer<int>(picture_.image[middle]) << 8 |
                    std::to_integer<int>(picture_.image[middle + 1]);
  EXPECT_NEAR(range, 1000, 60);  // 100 px * 60 mm / 6 px
}

TEST_F(CameraFramesTest, TwoEyesWithoutTheirDistanceAreRefused) {
  CameraFrames camera({.mode = camera_mode::kRange});
  camera.start(now_, *this);
  send_head(camera, {video::kGrey, 40, 12, 40});
  EXPECT_FALSE(give(camera, video::kGrey, std::vector<std::byte>(480)));
  ASSERT_TRUE(camera.failure());
  EXPECT_THAT(camera.failure()->detail(), testing::HasSubstr("stereoBase"));
}

TEST_F(CameraFramesTest, CalibratedPicturesAreRectified) {
  pictures::CameraCalibration shift{.width = 8,
                                    .height = 2,
                                    .camera = {.fx = 8, .fy = 8, .cx = 4, .cy = 1},
                                    .distortion = {0, 0, 0, 0, 0}};
  shift.rectified = shift.camera;
  shift.rectified.cx += 1;
  std::vector<std::byte> frame(16, std::byte{200});
  CameraFrames grey({.mode = camera_mode::kMono8, .calibration = shift});
  grey.start(now_, *this);
  send_head(grey, {video::kGrey, 8, 2, 8});
  ASSERT_TRUE(give(grey, video::kGrey, frame));
  EXPECT_EQ(picture_.image.at(0), std::byte{0});
  EXPECT_EQ(picture_.image.at(1), std::byte{200});
  // JPEG of the camera is not passed on.
  CameraData jpeg;
  ASSERT_TRUE(PictureMaker().compress(picture_, jpeg));
  CameraFrames compressed({.mode = camera_mode::kJpeg, .calibration = shift});
  compressed.start(now_, *this);
  ASSERT_TRUE(give(compressed, video::kMjpeg, jpeg.image));
  EXPECT_EQ(picture_.mode, camera_mode::kJpeg);
  EXPECT_NE(picture_.image, jpeg.image);
  EXPECT_EQ(picture_.width, 8);
  // Another aspect ratio.
  send_head(grey, {video::kGrey, 4, 4, 4});
  EXPECT_FALSE(give(grey, video::kGrey, frame));
  ASSERT_TRUE(grey.failure());
  EXPECT_THAT(grey.failure()->detail(), testing::HasSubstr("the camera: the calibration is for"));
}

}  // namespace camera_frames_test
}  // namespace rack::device

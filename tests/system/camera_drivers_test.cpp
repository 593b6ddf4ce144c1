// CameraV4l and CameraJpeg as real programs with recordings: every mode of every format, SET_FORMAT
// while they are on, cameras that are unplugged or send invalid pictures, stereo cameras.
#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/system/camera_fixture.h"

namespace tims::test {
namespace camera_drivers_test {

namespace device = rack::device;
namespace video = rack::device::video;
namespace camera_mode = rack::camera_mode;
using device::VideoHead;
using rack::CameraData;
using rack::u16;
using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

constexpr const char* kFrames = TIMS_TEST_DATA_DIR "/devices/camera/donkeycar-20.cap";

class CameraDriversTest : public CameraTest {};

// Left half dark, right half bright; `dark` and `bright` are the bytes of a pixel (or pair of
// pixels).
Bytes frame_of(const VideoHead& head, const Bytes& dark, const Bytes& bright) {
  Bytes frame;
  for (std::uint32_t y = 0; y < head.height; ++y)
    for (std::size_t x = 0; x < head.line_bytes; x += dark.size()) {
      const Bytes& pixel = x < head.line_bytes / 2 ? dark : bright;
      frame.insert(frame.end(), pixel.begin(), pixel.end());
    }
  return frame;
}

Bytes bytes(std::initializer_list<int> values) {
  Bytes all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

struct Mode {
  const char* name;  // name of the test
  VideoHead head;
  Bytes dark, bright;  // as the camera sends them
  const char* mode;
  u16 number;
  u16 depth;
  Bytes first, last;  // of the picture; empty: JPEG
};

void PrintTo(const Mode& mode, std::ostream* out) { *out << mode.name; }

class CameraModesTest : public CameraDriversTest, public testing::WithParamInterface<Mode> {};

TEST_P(CameraModesTest, IsProducedFromTheFormat) {
  const Mode& one = GetParam();
  Recording recording;
  recording.head(one.head);
  const Bytes frame = frame_of(one.head, one.dark, one.bright);
  for (int i = 0; i < 10; ++i) recording.add(one.head.format, frame);
  start("CameraV4l", {play(recording, "?loop=1"), std::string("--mode=") + one.mode});
  const auto on = camera().on();
  ASSERT_TRUE(on) << on.error().message();
  const CameraData picture = next_picture();
  EXPECT_EQ(picture.mode, one.number);
  EXPECT_EQ(picture.width, one.head.width);
  EXPECT_EQ(picture.height, one.head.height);
  EXPECT_EQ(picture.depth, one.depth);
  if (one.first.empty()) {
    EXPECT_EQ(picture.colorFilterId, picture.image.size());
    ASSERT_GT(picture.image.size(), 100U);
    EXPECT_EQ(picture.image[0], std::byte{0xFF});
    EXPECT_EQ(picture.image[1], std::byte{0xD8});
    return;
  }
  const std::span<const std::byte> image(picture.image);
  ASSERT_EQ(image.size(), std::size_t{one.head.width} * one.head.height * one.depth / 8);
  EXPECT_TRUE(std::ranges::equal(image.first(one.first.size()), one.first));
  EXPECT_TRUE(std::ranges::equal(image.last(one.last.size()), one.last));
}

constexpr VideoHead kGrey{video::kGrey, 32, 24, 32};
constexpr VideoHead kYuyv{video::kYuyv, 32, 24, 64};
constexpr VideoHead kUyvy{video::kUyvy, 32, 24, 64};
constexpr VideoHead kRgb{video::kRgb24, 32, 24, 96};
constexpr VideoHead kBgr{video::kBgr24, 32, 24, 96};
constexpr VideoHead kGrey16{video::kGrey16, 32, 24, 64};
constexpr VideoHead kDepth{video::kDepth16, 32, 24, 64};

INSTANTIATE_TEST_SUITE_P(
    All, CameraModesTest,
    testing::Values(Mode{"GreyMono8", kGrey, bytes({9}), bytes({200}), "mono8", 1, 8, bytes({9}),
                         bytes({200})},
                    Mode{"YuyvMono8", kYuyv, bytes({9, 128, 9, 128}), bytes({200, 128, 201, 128}),
                         "mono8", 1, 8, bytes({9, 9}), bytes({200, 201})},
                    Mode{"RgbMono8", kRgb, bytes({9, 9, 9}), bytes({200, 200, 200}), "mono8", 1, 8,
                         bytes({9}), bytes({200})},
                    Mode{"Grey16Mono16", kGrey16, bytes({2, 1}), bytes({4, 3}), "mono16", 3, 16,
                         bytes({1, 2}), bytes({3, 4})},
                    Mode{"RgbRgb24", kRgb, bytes({1, 2, 3}), bytes({4, 5, 6}), "rgb24", 11, 24,
                         bytes({3, 2, 1}), bytes({6, 5, 4})},
                    Mode{"BgrRgb24", kBgr, bytes({1, 2, 3}), bytes({4, 5, 6}), "rgb24", 11, 24,
                         bytes({1, 2, 3}), bytes({4, 5, 6})},
                    Mode{"UyvyRgb24", kUyvy, bytes({128, 16, 128, 16}), bytes({128, 235, 128, 235}),
                         "rgb24", 11, 24, bytes({0, 0, 0}), bytes({255, 255, 255})},
                    Mode{"YuyvYuv422", kYuyv, bytes({1, 2, 3, 4}), bytes({5, 6, 7, 8}), "yuv422",
                         21, 16, bytes({2, 1, 4, 3}), bytes({6, 5, 8, 7})},
                    Mode{"UyvyYuv422", kUyvy, bytes({1, 2, 3, 4}), bytes({5, 6, 7, 8}), "yuv422",
                         21, 16, bytes({1, 2, 3, 4}), bytes({5, 6, 7, 8})},
                    Mode{"DepthRange", kDepth, bytes({0xE8, 3}), bytes({0xD0, 7}), "range", 51, 16,
                         bytes({3, 0xE8}), bytes({7, 0xD0})},
                    Mode{"YuyvJpeg",
                         kYuyv,
                         bytes({9, 128, 9, 128}),
                         bytes({200, 128, 201, 128}),
                         "jpeg",
                         41,
                         24,
                         {},
                         {}},
                    Mode{"GreyJpeg", kGrey, bytes({9}), bytes({200}), "jpeg", 41, 24, {}, {}}),
    [](const auto& one) { return std::string(one.param.name); });

TEST_F(CameraDriversTest, AStereoCameraMeasuresDistances) {
  constexpr std::size_t kWidth = 80;
  constexpr std::size_t kHeight = 24;
  constexpr std::uint32_t kApart = 6;
  const VideoHead head{video::kGrey, 2 * kWidth, kHeight, 2 * kWidth};
  Bytes pair(2 * kWidth * kHeight);
  const auto texture = [](std::size_t x, std::size_t y) {
    return static_cast<std::byte>((x * 2654435761U ^ y * 40503U * 65537U) >> 24 & 0xFF);
  };
  for (std::size_t y = 0; y < kHeight; ++y)
    for (std::size_t x = 0; x < kWidth; ++x) {
      pair[y * 2 * kWidth + x] = texture(x, y);
      pair[y * 2 * kWidth + kWidth + x] = texture(x + kApart, y);
    }
  Recording recording;
  recording.head(head);
  for (int i = 0; i < 10; ++i) recording.add(head.format, pair);
  start("CameraV4l", {play(recording, "?loop=1"), "--mode=range", "--stereoBase=60", "--fx=100",
                      "--stereoDisparities=16"});
  ASSERT_TRUE(camera().on());
  const auto value_in_the_middle = [&](u16 mode) {
    CameraData picture;
    EXPECT_TRUE(eventually([&] { return (picture = next_picture()).mode == mode; }, "the mode"));
    EXPECT_EQ(picture.width, kWidth);
    EXPECT_EQ(picture.height, kHeight);
    const std::size_t middle = 2 * (kHeight / 2 * kWidth + kWidth / 2);
    if (picture.image.size() < middle + 2) return 0;
    return std::to_integer<int>(picture.image[middle]) << 8 |
           std::to_integer<int>(picture.image[middle + 1]);
  };
  EXPECT_NEAR(value_in_the_middle(camera_mode::kRange), 1000, 60);  // 60 mm * 100 px / 6 px
  ASSERT_TRUE(camera().set_format({.width = 80, .height = 24, .depth = 16, .mode = 59}));
  EXPECT_NEAR(value_in_the_middle(camera_mode::kDisparity), 16 * kApart, 4);
}

TEST_F(CameraDriversTest, TheFormatIsSetWhileItIsOn) {
  start("CameraV4l", {std::string("--device=play:") + kFrames + "?loop=1", "--mode=jpeg"});
  ASSERT_TRUE(camera().on());
  EXPECT_EQ(next_picture().mode, camera_mode::kJpeg);
  ASSERT_TRUE(camera().set_format({.width = 160, .height = 120, .depth = 8, .mode = 1}));
  EXPECT_TRUE(eventually([&] { return next_picture().mode == camera_mode::kMono8; }, "mono8"));
  EXPECT_EQ(camera().get_parameter()->calibration_width, 160);
  for (const rack::CameraFormatData& wrong : {rack::CameraFormatData{160, 120, 16, 1},
                                              {160, 120, 8, 12},
                                              {0, 120, 8, 1},
                                              {160, 70000, 8, 1},
                                              {160, 120, 24, 0}})
    EXPECT_FALSE(camera().set_format(wrong)) << wrong.mode;
  EXPECT_EQ(next_picture().mode, camera_mode::kMono8);
  // SET_FORMAT takes effect until one of the parameters is set.
  rack::Parameter mode;
  mode.name = "mode";
  mode.type = rack::Parameter::kString;
  mode.valueString = "yuv422";
  ASSERT_TRUE(camera().set_param(mode));
  ASSERT_TRUE(camera().off());
  ASSERT_TRUE(eventually([&] { return has_status(rack::Status::kDisabled); }, "off"));
  const auto on = camera().on();
  ASSERT_TRUE(on) << on.error().message();
  EXPECT_EQ(next_picture().mode, camera_mode::kYuv422);
}

TEST_F(CameraDriversTest, TheEndOfARecordingIsNoError) {
  Recording recording;
  recording.head(kGrey);
  for (int i = 0; i < 5; ++i) recording.add(kGrey.format, frame_of(kGrey, bytes({9}), bytes({9})));
  start("CameraV4l", {play(recording, ""), "--mode=mono8"});
  ASSERT_TRUE(camera().on());
  // Five periods without data; with a camera this would be an error.
  EXPECT_TRUE(eventually([&] { return !camera().get_next_data(1s); }, "its end"));
  EXPECT_TRUE(has_status(rack::Status::kEnabled));
  EXPECT_TRUE(camera().get_data());
}

TEST_F(CameraDriversTest, FramesOfAWrongSizeAreSkipped) {
  Recording recording;
  recording.head(kGrey);
  const Bytes frame = frame_of(kGrey, bytes({9}), bytes({200}));
  for (int i = 0; i < 20; ++i)
    recording.add(kGrey.format, i % 3 == 0 ? frame : Bytes(frame.begin(), frame.end() - 1));
  start("CameraV4l", {play(recording, "?loop=1"), "--mode=mono8"});
  ASSERT_TRUE(camera().on());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(next_picture().image.size(), frame.size());
  EXPECT_TRUE(has_status(rack::Status::kEnabled));
}

// A head with a larger format than the frames, and invalid pictures: a reason is reported, and no
// picture is sent.
TEST_F(CameraDriversTest, InvalidPicturesAreReportedWithTheReason) {
  Recording wrong_head;
  wrong_head.head({video::kGrey, 320, 240, 320});
  Recording broken;
  Recording huge;
  const Bytes half = bytes({0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0, 120, 0, 160, 1, 1, 0x11, 0, 0xFF});
  const Bytes lie =
      bytes({0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0xFF, 0xDC, 0xFF, 0xDC, 1, 1, 0x11, 0, 0xFF});
  for (int i = 0; i < 40; ++i) {
    wrong_head.add(video::kGrey, frame_of(kGrey, bytes({9}), bytes({9})), 5ms);
    broken.add(video::kMjpeg, half, 5ms);
    huge.add(video::kMjpeg, lie, 5ms);
  }
  struct Case {
    const Recording& recording;
    const char* mode;
    const char* reason;
  };
  for (const Case& one :
       {Case{wrong_head, "mono8", "does not have the size given by the camera"},
        Case{broken, "jpeg", "not a complete JPEG picture"},
        Case{broken, "rgb24", "invalid picture"}, Case{huge, "rgb24", "65500x65500"}}) {
    start("CameraV4l", {play(one.recording, "?loop=1"), std::string("--mode=") + one.mode});
    const auto on = camera().on();
    ASSERT_FALSE(on) << one.reason;
    EXPECT_THAT(on.error().message(), HasSubstr(one.reason));
    kill("CameraV4l");
  }
}

TEST_F(CameraDriversTest, CameraJpegNamesTheModesItCanCompress) {
  Recording recording;
  recording.head(kDepth);
  for (int i = 0; i < 10; ++i)
    recording.add(kDepth.format, frame_of(kDepth, bytes({1, 2}), bytes({3, 4})));
  start("CameraV4l", {play(recording, "?loop=1"), "--mode=range"});
  start("CameraJpeg", {"--instance=1", "--cameraInst=0"});
  const auto on = camera(kSecondCamera).on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), HasSubstr("use mono8, rgb24 or yuv422"));
}

}  // namespace camera_drivers_test
}  // namespace tims::test

#include "components/devices/io/dcam_modes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/core/video_frame.h"

namespace rack::device {
namespace dcam_modes_test {

using testing::HasSubstr;

std::vector<DcamMode> modes() {
  const std::vector<DcamRate> rates = {
      {DC1394_FRAMERATE_7_5, 7.5}, {DC1394_FRAMERATE_30, 30}, {DC1394_FRAMERATE_15, 15}};
  return {{.id = DC1394_VIDEO_MODE_640x480_YUV422,
           .coding = DC1394_COLOR_CODING_YUV422,
           .width = 640,
           .height = 480,
           .rates = rates},
          {.id = DC1394_VIDEO_MODE_640x480_MONO16,
           .coding = DC1394_COLOR_CODING_MONO16,
           .width = 640,
           .height = 480,
           .rates = rates},
          {.id = DC1394_VIDEO_MODE_1280x960_YUV422,
           .coding = DC1394_COLOR_CODING_YUV422,
           .width = 1280,
           .height = 960,
           .rates = rates},
          {.id = DC1394_VIDEO_MODE_FORMAT7_0,
           .coding = DC1394_COLOR_CODING_RAW8,
           .width = 1388,
           .height = 1038,
           .width_step = 4,
           .height_step = 2},
          {.id = DC1394_VIDEO_MODE_FORMAT7_1,
           .coding = DC1394_COLOR_CODING_YUV422,
           .width = 694,
           .height = 519,
           .width_step = 4,
           .height_step = 1}};
}

DcamChoice chosen(const VideoRequest& request) {
  const auto all = modes();
  const auto choice = choose_mode(all, request);
  EXPECT_TRUE(choice) << choice.error().message();
  return choice ? *choice : DcamChoice{};
}

TEST(DcamModes, TheFirstFormatThatHasTheSizeIsTaken) {
  EXPECT_EQ(chosen({{video::kGrey, video::kUyvy}, 640, 480, 15}).mode.id,
            DC1394_VIDEO_MODE_640x480_YUV422);
  EXPECT_EQ(chosen({{video::kGrey16}, 640, 480, 15}).mode.id, DC1394_VIDEO_MODE_640x480_MONO16);
  EXPECT_EQ(chosen({{video::kBggr}, 1280, 960, 15}).mode.id, DC1394_VIDEO_MODE_FORMAT7_0)
      << "whatever its pattern";
  const DcamChoice window = chosen({{video::kUyvy}, 400, 300, 15});
  EXPECT_EQ(window.mode.id, DC1394_VIDEO_MODE_FORMAT7_1);
  EXPECT_EQ(window.width, 400U);
  EXPECT_EQ(window.height, 300U);
  const DcamChoice any = chosen({});
  EXPECT_EQ(any.mode.id, DC1394_VIDEO_MODE_1280x960_YUV422);
  EXPECT_EQ(any.width, 1280U);
}

TEST(DcamModes, TheRateIsTheNextHigherOne) {
  const auto rate = [](double wanted) {
    return chosen({{video::kUyvy}, 640, 480, wanted}).rate.hertz;
  };
  EXPECT_EQ(rate(5), 7.5);
  EXPECT_EQ(rate(7.5), 7.5);
  EXPECT_EQ(rate(10), 15);
  EXPECT_EQ(rate(15.1), 30);
  EXPECT_EQ(rate(100), 30);
  EXPECT_EQ(rate(0), 30);
}

TEST(DcamModes, WhatTheCameraHasNotIsRefusedWithWhatItHas) {
  const auto all = modes();
  for (const VideoRequest& request :
       {VideoRequest{{video::kGrey}, 640, 480, 15}, VideoRequest{{video::kUyvy}, 800, 600, 15},
        VideoRequest{{video::kRggb}, 1390, 1038, 15}, VideoRequest{{video::kRggb}, 1388, 1040, 15},
        VideoRequest{{video::kRggb}, 1386, 1038, 15}, VideoRequest{{video::kRggb}, 1388, 1037, 15},
        VideoRequest{{video::kRggb16}, 1388, 1038, 15}}) {
    const auto choice = choose_mode(all, request);
    ASSERT_FALSE(choice);
    EXPECT_THAT(
        choice.error().detail(),
        HasSubstr("it has: 640x480 UYVY, 640x480 Y16 , 1280x960 UYVY, up to 1388x1038 raw8"));
  }
  EXPECT_TRUE(choose_mode(all, {{video::kRggb}, 1388, 1038, 15}));
  EXPECT_THAT(choose_mode({}, {}).error().detail(), HasSubstr("it has: none"));
}

TEST(DcamModes, CodingsAreFormats) {
  EXPECT_EQ(format_of(DC1394_COLOR_CODING_RAW8, DC1394_COLOR_FILTER_GBRG), video::kGbrg);
  EXPECT_EQ(format_of(DC1394_COLOR_CODING_RAW16, DC1394_COLOR_FILTER_BGGR),
            video::kBggr16 | video::kBigEndian);
  EXPECT_EQ(format_of(DC1394_COLOR_CODING_YUV411, DC1394_COLOR_FILTER_RGGB), 0U);
  for (const int filter : {0, 511, 516})
    EXPECT_EQ(format_of(DC1394_COLOR_CODING_RAW8, static_cast<dc1394color_filter_t>(filter)), 0U);
}

TEST(DcamModes, PacketsAreAsLargeAsTheRateRequires) {
  EXPECT_EQ(packet_bytes(800'000, 10, 4, 4096), 1000U);  // 800 packets
  EXPECT_EQ(packet_bytes(800'001, 10, 4, 4096), 1004U);
  EXPECT_EQ(packet_bytes(800'000, 40, 4, 4096), 4000U);
  EXPECT_EQ(packet_bytes(800'000, 60, 4, 4096), 4096U) << "as fast as possible";
  EXPECT_EQ(packet_bytes(1, 1, 4, 4096), 4U);
  EXPECT_EQ(packet_bytes(800'000, 0, 4, 4096), 4096U);
  EXPECT_EQ(packet_bytes(800'000, 10, 0, 4096), 4096U);
  EXPECT_EQ(packet_bytes(800'000, 1e9, 4, 4096), 4096U);
}

}  // namespace dcam_modes_test
}  // namespace rack::device

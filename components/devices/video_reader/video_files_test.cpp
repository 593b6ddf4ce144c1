// Video files and folders of pictures, as the driver of a camera gets them.
#include <fstream>

#include <gmock/gmock.h>

#include "components/devices/io/video_exchange.h"
#include "tests/support/video_fixture.h"

namespace rack::device {
namespace video_files_test {

using testing::HasSubstr;

class VideoFilesTest : public VideoTestBase {};

TEST_F(VideoFilesTest, MotionJpegIsHandedOnAsItIsAtItsOwnRate) {
  const auto video = open(write_video("a.avi", "MJPG", 10));
  ASSERT_TRUE(video->is_recording());
  const Time begin = tims::os::now();
  ASSERT_TRUE(receive_all(*video));
  ASSERT_EQ(frames_.size(), 10U);
  EXPECT_GE(tims::os::now() - begin, 450ms);
  for (int i = 0; i < 10; ++i) {
    const Frame& frame = frames_[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.head, (VideoHead{video::kMjpeg, 64, 48, 0}));
    EXPECT_NEAR(brightness_of(frame), brightness(i, 10), 4);
    EXPECT_NEAR(static_cast<double>((frame.when - frames_[0].when - i * 50ms).count()), 0, 1e6);
  }
  EXPECT_THAT(video->description(), HasSubstr("a.avi (64x48 mjpg, 20 per second)"));
  // After the end nothing wakes the driver.
  pollfd wait{.fd = video->descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&wait, 1, 0), 0);
  EXPECT_EQ(video->next_timeout(), tims::kNever);
}

TEST_F(VideoFilesTest, OtherFormatsAreDecodedAndNoFrameIsLeftOut) {
  for (const auto& [name, letters] : {std::pair("a.mp4", "mp4v"), std::pair("a.mkv", "H264")}) {
    const auto video = open(write_video(name, letters, 30) + "?speed=max");
    while (!video->is_over()) {
      ASSERT_TRUE(receive(*video, frames_.size() + 1));
      if (frames_.size() == 30) break;
      ::poll(nullptr, 0, 5);  // a slow reader
    }
    ASSERT_TRUE(receive_all(*video));
    ASSERT_EQ(frames_.size(), 30U) << name;
    for (int i = 0; i < 30; ++i) {
      EXPECT_EQ(frames_[static_cast<std::size_t>(i)].head, (VideoHead{video::kBgr24, 64, 48, 192}));
      EXPECT_NEAR(brightness_of(frames_[static_cast<std::size_t>(i)]), brightness(i, 30), 8) << i;
    }
  }
}

TEST_F(VideoFilesTest, RateAndSpeedSetTheTimes) {
  const std::string path = write_video("a.mp4", "mp4v", 5);
  for (const auto& [options, period] : {std::pair("?rate=100", 10ms), std::pair("?speed=2", 25ms),
                                        std::pair("?rate=50&speed=4", 5ms)}) {
    const auto video = open(path + options);
    ASSERT_TRUE(receive_all(*video));
    ASSERT_EQ(frames_.size(), 5U);
    EXPECT_EQ(frames_[4].when - frames_[0].when, 4 * period) << options;
  }
}

TEST_F(VideoFilesTest, ALoopGoesOnWithItsTimes) {
  const auto video = open(write_video("a.avi", "MJPG", 4) + "?loop=1&speed=5");
  ASSERT_TRUE(receive(*video, 14));
  EXPECT_FALSE(video->is_over());
  for (std::size_t i = 0; i < 14; ++i) {
    EXPECT_NEAR(brightness_of(frames_[i]), brightness(static_cast<int>(i % 4), 4), 4);
    EXPECT_EQ(frames_[i].when - frames_[0].when, i * 10ms) << i;
  }
}

TEST_F(VideoFilesTest, WhatIsNoVideoIsReportedWithTheReason) {
  const auto file = [&](const char* name, const std::string& content) {
    std::ofstream(folder_.path() / name) << content;
    return (folder_.path() / name).string();
  };
  EXPECT_THAT(failure_of(folder_.path() / "none.avi"), HasSubstr("No such file or directory"));
  EXPECT_THAT(failure_of(file("empty.avi", "")), HasSubstr("not a video that FFmpeg can read"));
  EXPECT_THAT(failure_of(file("a.cap", "# rack capture 1 x\n0.0 > 41\n")),
              HasSubstr("play:" + folder_.path().string() + "/a.cap"));
  EXPECT_THAT(failure_of(file("junk.mp4", std::string(5000, '\x5A'))),
              HasSubstr("not a video that FFmpeg can read"));
  // A list of files is not a video: it must not make FFmpeg read others.
  const std::string video = write_video("a.avi", "MJPG", 3);
  EXPECT_THAT(failure_of(file("list.m3u8", "#EXTM3U\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n")),
              HasSubstr("not a video"));
}

TEST_F(VideoFilesTest, DamagedVideosAreReadUpToTheDamage) {
  for (const auto& [name, letters] : {std::pair("a.avi", "MJPG"), std::pair("b.avi", "XVID")}) {
    const std::string path = write_video(name, letters, 40);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) * 4 / 5);
    const auto video = open(path + "?speed=max");
    const auto received = receive_all(*video);
    ASSERT_TRUE(received) << name << ": " << received.error().message();
    EXPECT_GT(frames_.size(), 5U) << name;
    EXPECT_LT(frames_.size(), 40U) << name;
  }
  const std::string path = write_video("a.mp4", "mp4v", 40);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  EXPECT_THAT(failure_of(path), HasSubstr("moov atom not found"));
}

TEST_F(VideoFilesTest, TheSizeOfPicturesHasALimit) {
  const auto largest = open(write_video("a.avi", "MJPG", 2, {4096, 3072}) + "?speed=max");
  ASSERT_TRUE(receive_all(*largest));
  EXPECT_EQ(frames_.size(), 2U);
  EXPECT_THAT(failure_of(write_video("b.avi", "MJPG", 2, {4096, 3074})), HasSubstr("37 MB"));
}

TEST_F(VideoFilesTest, AFolderIsReadByNames) {
  write_picture("b.jpg", cv::Scalar::all(80));
  write_picture("a.png", cv::Scalar(10, 20, 30));
  write_picture("c.JPEG", cv::Scalar::all(160));
  write_picture("d.ppm", cv::Scalar::all(200));
  std::ofstream(folder_.path() / "bb.jpg") << "no picture, but JPEG is not decoded here";
  std::ofstream(folder_.path() / "bbb.png") << "no picture";
  std::ofstream(folder_.path() / "e.txt") << "text";
  std::filesystem::remove(folder_.path() / "bb.jpg");
  const auto folder = open(folder_.path().string() + "?rate=50");
  ASSERT_TRUE(receive_all(*folder));
  ASSERT_EQ(frames_.size(), 4U);
  EXPECT_EQ(frames_[0].head, (VideoHead{video::kBgr24, 32, 24, 96}));
  EXPECT_EQ(frames_[0].bytes[0], std::byte{10});
  EXPECT_EQ(frames_[0].bytes[2], std::byte{30});
  EXPECT_EQ(frames_[1].head.format, video::kMjpeg);
  EXPECT_NEAR(brightness_of(frames_[1]), 80, 2);
  EXPECT_EQ(frames_[2].head.format, video::kMjpeg);
  EXPECT_EQ(brightness_of(frames_[3]), 200);
  EXPECT_EQ(frames_[1].when - frames_[0].when, 20ms);
  EXPECT_EQ(frames_[2].when - frames_[1].when, 40ms);  // the one between is damaged
  EXPECT_THAT(folder->description(), HasSubstr("5 pictures"));
}

TEST_F(VideoFilesTest, AFolderWithoutPicturesIsReported) {
  EXPECT_THAT(failure_of(folder_.path()), HasSubstr("a folder without pictures"));
  std::ofstream(folder_.path() / "a.png") << "no picture";
  EXPECT_THAT(failure_of(folder_.path()), HasSubstr("a.png: "));
  EXPECT_THAT(failure_of(folder_.path().string() + "?loop=1"), HasSubstr("a.png: "));
}

}  // namespace video_files_test
}  // namespace rack::device

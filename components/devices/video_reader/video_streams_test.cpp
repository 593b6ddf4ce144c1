// Streams of cameras in the network, lost ones, and the process that reads them.
#include <csignal>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/syscall.h>

#include "tests/support/mjpeg_server.h"
#include "tests/support/rtsp_server.h"
#include "tests/support/video_fixture.h"

namespace rack::device {
namespace video_streams_test {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;
using tims::test::MjpegAnswer;
using tims::test::MjpegServer;
using tims::test::RtspServer;

// Of this thread.
std::vector<pid_t> children() {
  std::ifstream file("/proc/self/task/" + std::to_string(::syscall(SYS_gettid)) + "/children");
  std::vector<pid_t> all;
  for (pid_t child = 0; file >> child;) all.push_back(child);
  return all;
}

class VideoStreamsTest : public VideoTestBase {
 protected:
  const std::string jpeg_ = jpeg_of(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(100)));
};

TEST_F(VideoStreamsTest, MotionJpegByHttpIsHandedOnAsItIs) {
  const MjpegServer camera({.jpeg = jpeg_});
  const auto stream = open(camera.url("admin:secret@"));
  EXPECT_FALSE(stream->is_recording());
  const Time begin = tims::os::now();
  ASSERT_TRUE(receive(*stream, 10));
  for (const Frame& frame : frames_) {
    EXPECT_EQ(frame.head.format, video::kMjpeg);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(frame.bytes.data()), frame.bytes.size()),
              jpeg_);
    EXPECT_GE(frame.when, begin);
  }
  EXPECT_GT(frames_[9].when, frames_[0].when);
  EXPECT_THAT(stream->description(), AllOf(HasSubstr("http://admin:***@127.0.0.1:"),
                                           HasSubstr("64x48"), Not(HasSubstr("secret"))));
}

TEST_F(VideoStreamsTest, RtspIsReadLostAndOpenedAgain) {
  const tims::test::RtspServerOptions options{.jpeg = jpeg_, .width = 64, .height = 48};
  auto camera = std::make_unique<RtspServer>(options);
  const std::uint16_t port = camera->port();
  const std::string url = camera->url();
  auto stream = open(url);
  ASSERT_TRUE(receive(*stream, 5));
  for (const Frame& frame : frames_) {
    EXPECT_EQ(frame.head.format, video::kMjpeg);
    EXPECT_NEAR(brightness_of(frame), 100, 3);
  }
  camera.reset();
  ASSERT_FALSE(receive_until(*stream, [] { return false; }));
  auto again = options;
  again.port = port;
  camera = std::make_unique<RtspServer>(again);
  stream = open(url);
  ASSERT_TRUE(receive(*stream, 5));
  // Cameras have few sessions: closed ones are given back.
  stream.reset();
  EXPECT_TRUE(tims::test::eventually([&] { return camera->teardowns() == 1; }, "TEARDOWN"));
}

TEST_F(VideoStreamsTest, ASlowReaderReceivesTheNewestFrame) {
  const MjpegServer camera({.jpeg = jpeg_, .period = 5ms});
  const auto stream = open(camera.url());
  ASSERT_TRUE(receive(*stream, 1));
  const std::uint32_t before = camera.pictures();
  const auto sends = [&](std::uint32_t pictures) {
    return tims::test::eventually([&] { return camera.pictures() > before + pictures; },
                                  "pictures");
  };
  ASSERT_TRUE(sends(20));
  const Time middle = tims::os::now();
  ASSERT_TRUE(sends(200));
  ASSERT_TRUE(receive(*stream, 2));
  EXPECT_EQ(frames_.size(), 2U);
  EXPECT_GT(frames_[1].when, middle);
}

TEST_F(VideoStreamsTest, ALostStreamIsReportedAndOpensAgain) {
  auto camera = std::make_unique<MjpegServer>(tims::test::MjpegServerOptions{.jpeg = jpeg_});
  const std::uint16_t port = camera->port();
  const std::string url = camera->url("admin:secret@");
  const auto stream = open(url);
  ASSERT_TRUE(receive(*stream, 3));
  camera.reset();
  const auto lost = receive_until(*stream, [] { return false; });
  ASSERT_FALSE(lost);
  EXPECT_THAT(lost.error().detail(),
              AllOf(HasSubstr("the stream has ended"), Not(HasSubstr("secret"))));
  EXPECT_THAT(failure_of(url), AllOf(HasSubstr("no video there"), HasSubstr("Connection refused")));
  camera =
      std::make_unique<MjpegServer>(tims::test::MjpegServerOptions{.jpeg = jpeg_, .port = port});
  const auto again = open(url);
  EXPECT_TRUE(receive(*again, 3));
}

TEST_F(VideoStreamsTest, WhatIsNoVideoIsReportedWithTheReason) {
  const MjpegServer missing({.answer = MjpegAnswer::kNotFound});
  EXPECT_THAT(failure_of(missing.url()), HasSubstr("HTTP error 404 Not Found"));
  const MjpegServer page({.answer = MjpegAnswer::kPage});
  EXPECT_THAT(failure_of(page.url()), HasSubstr("no video there"));
  const MjpegServer closed({.answer = MjpegAnswer::kUnauthorized});
  EXPECT_THAT(failure_of(closed.url()), HasSubstr("check address, user and password"));
  EXPECT_THAT(failure_of("http://nosuch.invalid/"), HasSubstr("nosuch.invalid"));
  EXPECT_THAT(failure_of("rtsp://127.0.0.1:9/stream1"), HasSubstr("refused"));
}

// It accepts the connection and does not answer.
TEST_F(VideoStreamsTest, ASilentCameraBlocksNeitherOpeningNorClosing) {
  const MjpegServer camera({.answer = MjpegAnswer::kSilence});
  const Time begin = tims::os::now();
  auto stream = open(camera.url());
  EXPECT_LT(tims::os::now() - begin, tims::test::kSlowdown * 1s);
  ASSERT_TRUE(tims::test::eventually([&] { return camera.clients() == 1; }, "the reader"));
  const Time close = tims::os::now();
  stream.reset();
  EXPECT_LT(tims::os::now() - close, tims::test::kSlowdown * 1s);
  EXPECT_TRUE(children().empty());
  // The reader gives up after 8 s, or is given up after 10 s.
  EXPECT_THAT(failure_of(camera.url()),
              AnyOf(HasSubstr("no video there"), HasSubstr("no picture within 10 s")));
}

TEST_F(VideoStreamsTest, AReaderThatCrashesIsReported) {
  const MjpegServer camera({.jpeg = jpeg_});
  const auto stream = open(camera.url());
  ASSERT_TRUE(receive(*stream, 1));
  ASSERT_EQ(children().size(), 1U);
  ::kill(children().front(), SIGKILL);
  const auto lost = receive_until(*stream, [] { return false; });
  ASSERT_FALSE(lost);
  EXPECT_THAT(lost.error().detail(), HasSubstr("the video reader has crashed"));
}

TEST_F(VideoStreamsTest, AMissingReaderIsReported) {
  const std::string path = tims::os::environment("PATH");
  ::setenv("PATH", "/nowhere", 1);  // NOLINT(concurrency-mt-unsafe)
  const auto opened = open_transport(*DeviceAddress::parse("http://127.0.0.1/"), 0);
  ::setenv("PATH", path.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail(),
              AllOf(HasSubstr("cannot run rack-video-reader"), HasSubstr("RACK_WITH_OPENCV=ON")));
}

}  // namespace video_streams_test
}  // namespace rack::device

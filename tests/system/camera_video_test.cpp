// CameraV4l with videos, folders of pictures, streams and pipelines instead of a camera of this
// host: their pictures, lost streams that come back, cameras that do not answer.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/support/eventually.h"
#include "tests/support/mjpeg_server.h"
#include "tests/system/camera_fixture.h"

namespace tims::test {
namespace camera_video_test {

namespace camera_mode = rack::camera_mode;
using rack::CameraData;
using testing::HasSubstr;
using testing::Not;

// Of a program: what it has started.
std::vector<pid_t> children_of(pid_t program) {
  std::vector<pid_t> all;
  const std::string tasks = "/proc/" + std::to_string(program) + "/task";
  std::error_code none;
  for (const auto& task : std::filesystem::directory_iterator(tasks, none)) {
    std::ifstream file(task.path() / "children");
    for (pid_t child = 0; file >> child;) all.push_back(child);
  }
  return all;
}

class CameraVideoTest : public CameraTest {
 protected:
  ChildProcess& start_camera(const std::string& device, const std::string& mode,
                             std::vector<std::string> more = {}) {
    more.insert(more.end(), {"--device=" + device, "--mode=" + mode});
    return start("CameraV4l", std::move(more));
  }
  // Blue, at 20 per second.
  std::string write_video(const char* name, const char* letters, int count) {
    std::string path = folder_.path() / name;
    cv::VideoWriter writer(path, cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc(letters[0], letters[1], letters[2], letters[3]),
                           20, {64, 48});
    for (int i = 0; i < count; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar(200, 60, 20)));
    return path;
  }
  static std::string jpeg() {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(200, 60, 20)), bytes);
    return {bytes.begin(), bytes.end()};
  }
};

TEST_F(CameraVideoTest, VideosBecomePicturesOfEveryMode) {
  const std::string avi = write_video("a.avi", "MJPG", 10);
  const std::string mp4 = write_video("a.mp4", "mp4v", 10);
  struct Case {
    std::string device;
    const char* mode;
    std::size_t size;  // 0: JPEG
  };
  for (const Case& one :
       {Case{avi, "jpeg", 0}, Case{avi, "rgb24", 9216}, Case{mp4, "jpeg", 0},
        Case{mp4, "rgb24", 9216}, Case{mp4, "mono8", 3072}, Case{mp4, "yuv422", 6144}}) {
    start_camera(one.device + "?loop=1", one.mode);
    const auto on = camera().on();
    ASSERT_TRUE(on) << one.device << ": " << on.error().message();
    const CameraData picture = next_picture();
    EXPECT_EQ(picture.width, 64);
    EXPECT_EQ(picture.height, 48);
    const std::span<const std::byte> image(picture.image);
    EXPECT_EQ(picture.mode == camera_mode::kJpeg, one.size == 0);
    EXPECT_TRUE(one.size == 0 || image.size() == one.size) << image.size();
    if (one.size == 9216) {
      EXPECT_NEAR(std::to_integer<int>(image[0]), 200, 8);
      EXPECT_NEAR(std::to_integer<int>(image[2]), 20, 8);
    }
    kill("CameraV4l");
  }
}

TEST_F(CameraVideoTest, AFileIsPlayedOnceAtItsOwnRateAndItsEndIsNoError) {
  start_camera(write_video("a.avi", "MJPG", 30), "mono8", {"--fps=5"});
  ASSERT_TRUE(camera().on());
  const auto first = next_picture().recordingTime;
  const auto second = next_picture().recordingTime;
  EXPECT_NEAR(static_cast<double>((second - first).count()), 50, 1);  // not 200: all are published
  EXPECT_TRUE(eventually([&] { return !camera().get_next_data(1s); }, "its end"));
  EXPECT_TRUE(has_status(rack::Status::kEnabled));
}

TEST_F(CameraVideoTest, AFolderIsPlayedAtFps) {
  for (const char* name : {"a.png", "b.jpg"})
    cv::imwrite(folder_.path() / name, cv::Mat(48, 64, CV_8UC3, cv::Scalar(200, 60, 20)));
  start_camera(folder_.path().string() + "?loop=1", "rgb24", {"--fps=10"});
  ASSERT_TRUE(camera().on());
  const auto first = next_picture().recordingTime;
  const auto second = next_picture().recordingTime;
  EXPECT_NEAR(static_cast<double>((second - first).count()), 100, 1);
}

TEST_F(CameraVideoTest, ALostStreamIsAnErrorAndComesBack) {
  auto server = std::make_unique<MjpegServer>(MjpegServerOptions{.jpeg = jpeg()});
  const std::uint16_t port = server->port();
  auto& program = start_camera(server->url("admin:secret@"), "jpeg", {"--fps=30"});
  ASSERT_TRUE(camera().on());
  EXPECT_EQ(next_picture().image.size(), jpeg().size());
  server.reset();
  EXPECT_TRUE(eventually([&] { return has_status(rack::Status::kError); }, "error"));
  EXPECT_TRUE(program.wait_for_line("the stream has ended"));
  EXPECT_TRUE(program.wait_for_line("Connection refused"));
  server = std::make_unique<MjpegServer>(MjpegServerOptions{.jpeg = jpeg(), .port = port});
  EXPECT_TRUE(eventually([&] { return has_status(rack::Status::kEnabled); }, "back"));
  EXPECT_EQ(next_picture().image.size(), jpeg().size());
  EXPECT_THAT(program.output(), HasSubstr("admin:***@127.0.0.1"));
  EXPECT_THAT(program.output(), Not(HasSubstr("secret")));
}

// The connection stays, and no picture comes.
TEST_F(CameraVideoTest, AStreamThatStandsStillIsAnError) {
  const MjpegServer server({.jpeg = jpeg(), .pauses_after = 20});
  auto& program = start_camera(server.url(), "jpeg", {"--fps=30"});
  ASSERT_TRUE(camera().on());
  const auto line = program.wait_for_line("has sent no data for ");
  EXPECT_TRUE(line) << line.error().message();
  EXPECT_TRUE(eventually([&] { return server.clients() > 1; }, "the next attempt"));
}

TEST_F(CameraVideoTest, WithACameraThatDoesNotAnswerItIsTurnedOffAndEndsAtOnce) {
  const MjpegServer server({.answer = MjpegAnswer::kSilence});
  auto& program = start_camera(server.url(), "jpeg");
  auto impatient = rack::CameraProxy(*work_, Address(kCamera), {.on = 500ms, .off = kPatience});
  EXPECT_FALSE(impatient.on());
  ASSERT_TRUE(eventually([&] { return server.clients() > 0; }, "the reader"));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(impatient.off());
  EXPECT_TRUE(eventually([&] { return children_of(program.pid()).empty(); }, "no reader"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kSlowdown * 2s);
  EXPECT_FALSE(impatient.on());
  std::vector<pid_t> readers;
  ASSERT_TRUE(
      eventually([&] { return !(readers = children_of(program.pid())).empty(); }, "reader"));
  const auto interrupt = std::chrono::steady_clock::now();
  const auto ended = program.stop(SIGINT);
  ASSERT_TRUE(ended) << ended.error().message();
  EXPECT_TRUE(ended->success()) << ended->to_string();
  EXPECT_LT(std::chrono::steady_clock::now() - interrupt, kSlowdown * 3s);
  for (const pid_t reader : readers) EXPECT_NE(::kill(reader, 0), 0);
}

TEST_F(CameraVideoTest, ADriverThatIsKilledLeavesNoReader) {
  const MjpegServer server({.jpeg = jpeg()});
  auto& program = start_camera(server.url(), "jpeg");
  ASSERT_TRUE(camera().on());
  const auto readers = children_of(program.pid());
  ASSERT_EQ(readers.size(), 1U);
  kill("CameraV4l");
  EXPECT_TRUE(eventually(
      [&] {
        return !std::filesystem::exists("/proc/" + std::to_string(readers.front()) + "/fd/0");
      },
      "the end of the reader"));
}

TEST_F(CameraVideoTest, WhatIsNoVideoIsReported) {
  auto& program = start_camera(folder_.path() / "none.mp4", "jpeg");
  const auto on = camera().on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), HasSubstr("none.mp4: No such file or directory"));
  EXPECT_TRUE(program.wait_for_line("No such file or directory"));
}

}  // namespace camera_video_test
}  // namespace tims::test

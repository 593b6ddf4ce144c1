// Tests with a real camera, or vivid (modprobe vivid), skipped without /dev/video0. Errors of
// missing devices are always tested.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "components/devices/core/video_frame.h"
#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "rack/devices/transport.h"

namespace rack::device {
namespace video_test {

using namespace std::chrono_literals;

// RACK_TEST_VIDEO: another camera than the first.
std::string camera() {
  const char* const other = std::getenv("RACK_TEST_VIDEO");  // NOLINT(concurrency-mt-unsafe)
  return other == nullptr ? "/dev/video0" : other;
}

class VideoTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(camera())) GTEST_SKIP() << "no " << camera();
  }
  static tims::Result<std::unique_ptr<Transport>> open(const std::string& options) {
    return open_transport(*DeviceAddress::parse("v4l:" + camera() + options), 0);
  }
};

TEST_F(VideoTest, FramesComeWithTheirHeadAndTheirTimes) {
  const auto opened = open("?size=640x480&format=YUYV,MJPG");
  ASSERT_TRUE(opened) << opened.error().message();
  const Time begin = tims::os::now();
  std::optional<VideoHead> head;
  std::vector<Time> times;
  std::size_t bytes = 0;
  while (times.size() < 10 && tims::os::now() < begin + 20s) {
    pollfd wait{.fd = (*opened)->descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&wait, 1, 100);
    const auto received = (*opened)->receive(tims::os::now(), [&](const Arrival& arrival) {
      if (arrival.id == video::kHead) head = video_head(arrival.bytes);
      if (!head || arrival.id != head->format) return;
      times.push_back(arrival.last);
      bytes = arrival.bytes.size();
    });
    ASSERT_TRUE(received) << received.error().message();
  }
  ASSERT_TRUE(head);
  ASSERT_EQ(times.size(), 10U);
  EXPECT_GT(head->width, 0U);
  if (head->format == video::kYuyv) {
    EXPECT_GE(bytes, std::size_t{head->width} * head->height * 2);
  }
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i], times[i - 1]);
  EXPECT_LE(times.back(), tims::os::now());
}

TEST_F(VideoTest, AFormatItHasNotIsRefusedWithWhatItHas) {
  const auto opened = open("?format=QQQQ");
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail(),
              testing::HasSubstr("none of the requested formats; supported: "));
  EXPECT_FALSE(check_video(*DeviceAddress::parse("v4l:" + camera() + "?format=QQQQ")));
}

TEST_F(VideoTest, TwoProgramsDoNotShareIt) {
  const auto first = open("?size=640x480");
  ASSERT_TRUE(first) << first.error().message();
  const auto second = open("?size=320x240");
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().detail(), testing::HasSubstr("used by another program"));
  // Queries are allowed while another program uses the camera.
  EXPECT_TRUE(check_video(*DeviceAddress::parse("v4l:" + camera() + "?size=640x480")));
}

TEST_F(VideoTest, ItOpensAgainAtOnce) {
  for (int i = 0; i < 3; ++i) {
    const auto opened = open("?size=640x480");
    EXPECT_TRUE(opened) << opened.error().message();
  }
}

TEST(VideoMissingTest, AMissingCameraIsReportedWithAHint) {
  const auto opened = open_transport(*DeviceAddress::parse("v4l:/dev/videoNONE"), 0);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail(), testing::HasSubstr("timsctl device list"));
  const auto no_camera = open_transport(*DeviceAddress::parse("v4l:/dev/null"), 0);
  ASSERT_FALSE(no_camera);
  EXPECT_THAT(no_camera.error().detail(), testing::HasSubstr("not a camera"));
  for (const auto* options : {"?size=640", "?size=ax3", "?rate=0", "?format=ABCDE", "?format=,"})
    EXPECT_FALSE(open_transport(*DeviceAddress::parse(std::string("v4l:/dev/null") + options), 0))
        << options;
}

TEST(PicturesTest, AFolderIsPlayedByNames) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "pictures_of_video_test";
  std::filesystem::create_directories(folder);
  EXPECT_FALSE(open_transport(*DeviceAddress::parse("play:" + folder.string()), 0));
  for (const char* const name : {"b.jpg", "a.jpg", "c.txt"})
    std::ofstream(folder / name) << std::string("picture ") + name;
  const auto opened =
      open_transport(*DeviceAddress::parse("play:" + folder.string() + "?speed=max"), 0);
  ASSERT_TRUE(opened) << opened.error().message();
  std::string text;
  while (!(*opened)->is_over())
    ASSERT_TRUE((*opened)->receive(tims::os::now(), [&](const Arrival& arrival) {
      EXPECT_EQ(arrival.id, video::kMjpeg);
      for (const std::byte byte : arrival.bytes) text += static_cast<char>(byte);
    }));
  EXPECT_EQ(text, "picture a.jpgpicture b.jpg");
  std::filesystem::remove_all(folder);
}

TEST(GpioMissingTest, AMissingDeviceIsReported) {
  const auto nothing = open_transport(*DeviceAddress::parse("gpio:/dev/gpiochip99?in=1"), 0);
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().detail(), testing::HasSubstr("gpiochip99"));
  for (const auto* options : {"", "?in=a", "?in=1&bias=some"}) {
    const auto wrong =
        open_transport(*DeviceAddress::parse(std::string("gpio:/dev/null") + options), 0);
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code(), tims::Errc::kInvalidArgument) << options;
  }
  EXPECT_FALSE(open_transport(*DeviceAddress::parse("gpio:/dev/null?in=1"), 0));
}

TEST(UsbMissingTest, AMissingDeviceIsReported) {
  const auto opened = open_transport(*DeviceAddress::parse("usb:fffe:fffe/H0712345"), 0);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail(), testing::HasSubstr("USB"));
}

}  // namespace video_test
}  // namespace rack::device

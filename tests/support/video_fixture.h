// What tests of videos share: the transport with the real reader, and videos to read.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <unistd.h>

#include "components/devices/core/video_frame.h"
#include "os/clock.h"
#include "os/environment.h"
#include "rack/devices/transport.h"
#include "tests/support/eventually.h"
#include "tests/support/receive_until.h"
#include "tests/support/temporary_folder.h"

namespace rack::device {

using namespace std::chrono_literals;

class VideoTestBase : public testing::Test {
 protected:
  struct Frame {
    VideoHead head{};
    std::vector<std::byte> bytes{};
    Time when{};
  };

  // The reader is installed elsewhere than tests.
  static void SetUpTestSuite() {
    const std::string path = std::string(VIDEO_READER_FOLDER) + ":" + tims::os::environment("PATH");
    ::setenv("PATH", path.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }

  std::unique_ptr<Transport> open(const std::string& text) {
    frames_.clear();
    head_.reset();
    const auto address = DeviceAddress::parse(text);
    EXPECT_TRUE(address) << address.error().message();
    auto opened = open_transport(*address, 0);
    EXPECT_TRUE(opened) << opened.error().message();
    return opened ? std::move(*opened) : nullptr;
  }

  // Receives until the condition is met or the transport has failed.
  template <typename Condition>
  tims::Result<void> receive_until(Transport& transport, Condition condition) {
    auto received =
        device::receive_until(transport, condition, [&](const Arrival& arrival) { take(arrival); });
    if (!received) return received;
    EXPECT_TRUE(condition()) << "after " << frames_.size() << " frames";
    return {};
  }
  void take(const Arrival& arrival) {
    if (arrival.id == video::kHead) {
      head_ = video_head(arrival.bytes);
      return;
    }
    ASSERT_TRUE(head_);
    EXPECT_EQ(arrival.id, head_->format);
    EXPECT_LE(arrival.last, tims::os::now());
    frames_.push_back({*head_, {arrival.bytes.begin(), arrival.bytes.end()}, arrival.last});
  }
  tims::Result<void> receive_all(Transport& transport) {
    return receive_until(transport, [&] { return transport.is_over(); });
  }
  tims::Result<void> receive(Transport& transport, std::size_t frames) {
    return receive_until(transport, [&] { return frames_.size() >= frames; });
  }
  // The reason of the failure that is expected.
  std::string failure_of(const std::string& address) {
    const auto transport = open(address);
    if (transport == nullptr) return "not opened";
    const auto received = receive_until(*transport, [] { return false; });
    return received ? "good" : received.error().detail();
  }

  // Frame i of `count` is dark to bright; its brightness is brightness(i, count).
  static int brightness(int i, int count) { return 20 + 200 * i / count; }
  std::string write_video(const char* name, const char* letters, int count,
                          cv::Size size = {64, 48}, double rate = 20) {
    std::string path = folder_.path() / name;
    cv::VideoWriter writer(path, cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc(letters[0], letters[1], letters[2], letters[3]),
                           rate, size);
    EXPECT_TRUE(writer.isOpened()) << path;
    for (int i = 0; i < count; ++i)
      writer.write(cv::Mat(size, CV_8UC3, cv::Scalar::all(brightness(i, count))));
    return path;
  }
  std::string write_picture(const std::string& name, const cv::Scalar& colour) {
    std::string path = folder_.path() / name;
    EXPECT_TRUE(cv::imwrite(path, cv::Mat(24, 32, CV_8UC3, colour)));
    return path;
  }
  static std::string jpeg_of(const cv::Mat& picture) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", picture, bytes);
    return {bytes.begin(), bytes.end()};
  }
  static int brightness_of(const Frame& frame) {
    if (frame.head.format != video::kMjpeg)
      return frame.bytes.empty() ? -1 : std::to_integer<int>(frame.bytes.front());
    const cv::Mat bytes(1, static_cast<int>(frame.bytes.size()), CV_8U,
                        const_cast<std::byte*>(frame.bytes.data()));
    const cv::Mat picture = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    return picture.empty() ? -1 : picture.at<unsigned char>(0, 0);
  }

  tims::test::TemporaryFolder folder_;
  std::vector<Frame> frames_;
  std::optional<VideoHead> head_;
};

}  // namespace rack::device

#include "components/devices/camera/ip_camera.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device::emulator {
namespace ip_camera_test {

using namespace std::chrono_literals;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class Sent final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t) override {
    pieces.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  std::vector<std::string> pieces;
};

// Pictures "picture 1", "picture 2", ... that are ready some time after they were ordered.
class SlowPictures final : public PictureSource {
 public:
  [[nodiscard]] Duration period() const override { return 100ms; }
  void order(Time when) override {
    if (is_busy) return;
    ordered.push_back(when);
    is_busy = true;
  }
  bool take(std::vector<std::byte>& jpeg) override {
    if (!is_busy || now < ordered.back() + takes) return false;
    is_busy = false;
    const std::string text = "picture " + std::to_string(ordered.size());
    const auto bytes = std::as_bytes(std::span(text));
    jpeg.assign(bytes.begin(), bytes.end());
    jpeg.resize(std::max(jpeg.size(), size));
    return true;
  }

  Time now{};
  Duration takes = 10ms;
  std::size_t size = 0;
  bool is_busy = false;
  std::vector<Time> ordered;
};

class IpCameraTest : public testing::Test {
 protected:
  static constexpr Time kBegin{1000s};

  IpCameraTest() { camera_.start(now_, out_); }

  void receive(std::string_view text) {
    camera_.on_arrival({.bytes = std::as_bytes(std::span(text)), .first = now_, .last = now_},
                       out_);
  }
  void run(Duration time) {
    for (const Time end = now_ + time; camera_.next_timeout() <= end;) {
      pictures_->now = now_ = std::max(now_, camera_.next_timeout());
      camera_.on_timeout(now_, out_);
    }
    pictures_->now = now_ = std::max(now_, kBegin) + time - (now_ - kBegin) % time;
  }

  std::shared_ptr<SlowPictures> pictures_ = std::make_shared<SlowPictures>();
  IpCamera camera_{{.pictures = pictures_}};
  Time now_ = kBegin;
  Sent out_;
};

TEST_F(IpCameraTest, SendsPicturesAtItsRateAsLongAsAClientWantsThem) {
  run(1s);
  EXPECT_TRUE(pictures_->ordered.empty()) << "nobody wants any";
  receive("GET / HTTP/1.1\r\nHost: robot\r\n\r\n");
  ASSERT_EQ(out_.pieces.size(), 1U);
  EXPECT_THAT(out_.pieces[0], StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(out_.pieces[0], HasSubstr("multipart/x-mixed-replace; boundary=rack-picture\r\n"));
  EXPECT_THAT(out_.pieces[0], EndsWith("\r\n\r\n"));
  run(1s);
  EXPECT_NEAR(static_cast<double>(out_.pieces.size()), 11, 1);
  EXPECT_EQ(out_.pieces[2],
            "--rack-picture\r\nContent-Type: image/jpeg\r\nContent-Length: 9\r\n\r\npicture 2\r\n");
  EXPECT_EQ(pictures_->ordered[3] - pictures_->ordered[2], 100ms);
  camera_.start(now_, out_);  // the client has gone
  const std::size_t ordered = pictures_->ordered.size();
  run(1s);
  EXPECT_EQ(pictures_->ordered.size(), ordered);
}

TEST_F(IpCameraTest, SendsOnePicture) {
  receive("GET /picture.jpg?now HTTP/1.0\r\n\r\n");
  run(1s);
  ASSERT_EQ(out_.pieces.size(), 1U);
  EXPECT_EQ(out_.pieces[0],
            "HTTP/1.1 200 OK\r\nContent-Type: image/jpeg\r\nContent-Length: 9\r\n\r\npicture 1");
  EXPECT_EQ(pictures_->ordered.size(), 1U);
}

TEST_F(IpCameraTest, SkipsPicturesThatItCannotMakeInTime) {
  pictures_->takes = 250ms;
  receive("GET / HTTP/1.1\r\n\r\n");
  run(3s);
  for (std::size_t i = 1; i < pictures_->ordered.size(); ++i)
    EXPECT_EQ(pictures_->ordered[i] - pictures_->ordered[i - 1], 300ms) << "none waits in a queue";
}

TEST_F(IpCameraTest, TakesARequestInAnyPieces) {
  const std::string request = "GET /picture.jpg HTTP/1.1\r\nHost: robot\r\n\r\n";
  for (std::size_t cut = 0; cut < request.size(); ++cut) {
    out_.pieces.clear();
    receive(std::string_view(request).substr(0, cut));
    run(1s);
    EXPECT_TRUE(out_.pieces.empty()) << cut;
    receive(std::string_view(request).substr(cut));
    run(1s);
    EXPECT_EQ(out_.pieces.size(), 1U) << cut;
  }
}

TEST_F(IpCameraTest, RefusesWhatItDoesNotHave) {
  const std::pair<std::string, std::string> cases[] = {
      {"GET /other HTTP/1.1\r\n\r\n", "404"},
      {"POST / HTTP/1.1\r\n\r\n", "405"},
      {"GET /\r\n\r\n", "400"},
      {"\r\n\r\n", "400"},
      {"GET http:// HTTP/1.1\r\n\r\n", "400"},
      {"GET  / HTTP/1.1\r\n\r\n", "400"},
      {std::string("\0\xFF\0 / HTTP/1.1\r\n\r\n", 18), "405"},
  };
  for (const auto& [request, status] : cases) {
    out_.pieces.clear();
    receive(request);
    run(1s);
    ASSERT_EQ(out_.pieces.size(), 1U) << request;
    EXPECT_THAT(out_.pieces[0], StartsWith("HTTP/1.1 " + status)) << request;
  }
  EXPECT_TRUE(pictures_->ordered.empty());
}

TEST_F(IpCameraTest, RefusesARequestWithoutEnd) {
  const std::string all = "GET / HTTP/1.1\r\nX: " + std::string(IpCamera::kRequestBytesMax, 'x');
  receive(std::string_view(all).substr(0, IpCamera::kRequestBytesMax));
  EXPECT_TRUE(out_.pieces.empty()) << "its end may still follow";
  receive(std::string_view(all).substr(IpCamera::kRequestBytesMax));
  ASSERT_EQ(out_.pieces.size(), 1U);
  EXPECT_THAT(out_.pieces[0], StartsWith("HTTP/1.1 431"));
  receive("GET /picture.jpg HTTP/1.1\r\n\r\n");
  run(1s);
  EXPECT_EQ(out_.pieces.size(), 2U) << "and serves the next one";
}

TEST_F(IpCameraTest, SkipsPicturesThatAreTooLarge) {
  for (const std::size_t size : {IpCamera::kPictureBytesMax, IpCamera::kPictureBytesMax + 1}) {
    out_.pieces.clear();
    pictures_->size = size;
    receive("GET /picture.jpg HTTP/1.1\r\n\r\n");
    run(1s);
    EXPECT_EQ(out_.pieces.size(), size == IpCamera::kPictureBytesMax ? 1U : 0U);
  }
}

TEST(IpCameraTestPictures, AreTwoInTurn) {
  IpCamera camera;
  Sent out;
  Time now{1000s};
  camera.start(now, out);
  const std::string_view request = "GET / HTTP/1.1\r\n\r\n";
  camera.on_arrival({.bytes = std::as_bytes(std::span(request)), .first = now, .last = now}, out);
  while (out.pieces.size() < 4) {
    now = std::max(now, camera.next_timeout());
    camera.on_timeout(now, out);
  }
  EXPECT_THAT(out.pieces[1], HasSubstr("\r\n\r\n\xFF\xD8"));
  EXPECT_NE(out.pieces[1], out.pieces[2]);
  EXPECT_EQ(out.pieces[1], out.pieces[3]);
}

}  // namespace ip_camera_test
}  // namespace rack::device::emulator

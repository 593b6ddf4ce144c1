// Videos by cv::VideoCapture: files and streams by FFmpeg, pipelines by GStreamer.
//
// Motion JPEG is handed on as it is. That is FFmpeg without its decoder, which OpenCV can only be
// asked for before the first frame is read.
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "components/devices/io/video_exchange.h"
#include "components/devices/video_reader/frame_source.h"
#include "components/pictures/opencv_call.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;

constexpr int kOpenMs = 8000;  // before the program that started this gives up
constexpr int kReadMs = 4000;
constexpr double kSideMax = 0xFFFF;
constexpr double kRateMax = 1000;
constexpr double kVideoRate = 25;

// What FFmpeg may open on behalf of a source: a stream must not read files of this computer.
constexpr const char* kFileOptions = "protocol_whitelist;file";
constexpr const char* kStreamOptions =
    "rtsp_transport;tcp|"
    "protocol_whitelist;rtsp,rtsps,rtp,srtp,udp,tcp,tls,http,https,httpproxy,crypto,data";

std::string four_letters_of(double code) {
  std::string letters = letters_of(static_cast<std::uint32_t>(std::llround(code)));
  std::ranges::transform(letters, letters.begin(), [](unsigned char c) { return std::tolower(c); });
  return letters;
}

std::string text_of_number(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", number);
  return text.data();
}

// "mjpe": of streams, which have no letters but a name, mjpeg.
bool is_motion_jpeg(const std::string& letters) { return letters == "mjpg" || letters == "mjpe"; }

// OpenCV takes the pictures from an appsink, which pipelines for gst-launch do not have.
std::string with_sink(const std::string& pipeline) {
  if (pipeline.find("appsink") != std::string::npos) return pipeline;
  return pipeline + " ! videoconvert ! appsink drop=true max-buffers=1";
}

class CaptureSource final : public FrameSource {
 public:
  explicit CaptureSource(const DeviceAddress& address) : address_(address) {}

  Result<void> open() {
    bool is_open = false;
    auto opened =
        pictures::call_opencv("cannot open it", [&] { is_open = open_capture_of_kind(); });
    if (!opened) return opened;
    if (!is_open) return Error(Errc::kSystem, why_not_open());
    if (address_.kind != TransportKind::kGstreamer) take_properties();
    if (width_ > kSideMax || height_ > kSideMax || width_ * height_ * 3 > kVideoFrameBytesMax)
      return too_large();
    return {};
  }

  Result<bool> next(SourceFrame& frame) override {
    bool has_frame = false;
    auto read = pictures::call_opencv("cannot read it", [&] {
      has_frame = capture_.grab();
      const double at =
          is_raw_ || !has_frame || !is_file() ? -1 : capture_.get(cv::CAP_PROP_POS_MSEC);
      has_frame = has_frame && capture_.retrieve(mat_);
      media_ms_ = at >= 0 && at < 1e12 && address_.rate() == 0 ? at : 1e3 * frames_ / rate_;
    });
    if (!read) return read.error();
    if (!has_frame && !is_file()) return Error(Errc::kSystem, "the stream has ended");
    if (!has_frame && frames_ == 0) return Error(Errc::kMalformed, "no picture can be decoded");
    if (!has_frame) return false;
    ++frames_;
    frame.media = tims::Duration(std::llround(media_ms_ * 1e6));
    return take(frame);
  }

  [[nodiscard]] std::string description() const override {
    if (width_ <= 0) return {};
    return text_of_number(width_) + "x" + text_of_number(height_) + " " + letters_ +
           (is_file() ? ", " + text_of_number(rate_) + " per second" : "");
  }

 private:
  [[nodiscard]] bool is_file() const { return address_.kind == TransportKind::kFile; }

  bool open_capture_of_kind() {
    if (address_.kind == TransportKind::kGstreamer)
      return capture_.open(with_sink(address_.place), cv::CAP_GSTREAMER);
    // The other thread (employer.h) does not read it.
    const char* const options = is_file() ? kFileOptions : kStreamOptions;
    ::setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", options, 0);  // NOLINT(concurrency-mt-unsafe)
    // An absolute path cannot be taken for a protocol.
    const std::string place =
        is_file() ? std::filesystem::absolute(address_.place).string() : address_.place;
    return capture_.open(
        place, cv::CAP_FFMPEG,
        {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, kOpenMs, cv::CAP_PROP_READ_TIMEOUT_MSEC, kReadMs});
  }

  [[nodiscard]] std::string why_not_open() const {
    if (address_.kind == TransportKind::kGstreamer)
      return "GStreamer cannot start this pipeline (its elements are in gstreamer1.0-plugins-base, "
             "-good, -bad)";
    if (address_.kind == TransportKind::kStream)
      return "no video there (check address, user and password: rtsp://USER:PASSWORD@HOST/PATH)";
    return "not a video that FFmpeg can read (a recording is played by play:" + address_.place +
           ")";
  }

  void take_properties() {
    width_ = capture_.get(cv::CAP_PROP_FRAME_WIDTH);
    height_ = capture_.get(cv::CAP_PROP_FRAME_HEIGHT);
    letters_ = four_letters_of(capture_.get(cv::CAP_PROP_FOURCC));
    const double rate = capture_.get(cv::CAP_PROP_FPS);
    rate_ = rate > 0 && rate <= kRateMax ? rate : kVideoRate;
    if (address_.rate() > 0) rate_ = address_.rate();
    if (is_motion_jpeg(letters_)) is_raw_ = capture_.set(cv::CAP_PROP_FORMAT, -1);
  }

  Result<bool> take(SourceFrame& frame) {
    const std::size_t bytes = mat_.total() * mat_.elemSize();
    if (mat_.empty() || !mat_.isContinuous())
      return Error(Errc::kMalformed, "a frame without pixels");
    if (mat_.cols > kSideMax && mat_.rows > 1) return too_large();
    if (bytes > kVideoFrameBytesMax) return too_large();
    frame.bytes = std::as_bytes(std::span(mat_.data, bytes));
    const auto width = static_cast<std::uint32_t>(mat_.cols);
    const auto height = static_cast<std::uint32_t>(mat_.rows);
    const auto line = static_cast<std::uint32_t>(mat_.cols * mat_.channels());
    if (is_raw_ || is_jpeg(mat_))
      frame.head = {.format = video::kMjpeg,
                    .width = static_cast<std::uint32_t>(std::max(0.0, width_)),
                    .height = static_cast<std::uint32_t>(std::max(0.0, height_))};
    else if (mat_.type() == CV_8UC3)
      frame.head = {video::kBgr24, width, height, line};
    else if (mat_.type() == CV_8UC1)
      frame.head = {video::kGrey, width, height, line};
    else
      return Error(
          Errc::kInvalidArgument,
          "frames are not BGR, grey or JPEG; end the pipeline with ! videoconvert ! appsink");
    return true;
  }

  // A pipeline that ends with image/jpeg delivers its bytes as a matrix of one line.
  static bool is_jpeg(const cv::Mat& mat) {
    return mat.type() == CV_8UC1 && mat.rows == 1 && mat.cols > 2 && mat.data[0] == 0xFF &&
           mat.data[1] == 0xD8;
  }

  [[nodiscard]] static Error too_large() {
    return {Errc::kTooBig, "its pictures have more than 65535 pixels in a line or 37 MB"};
  }

  DeviceAddress address_;
  cv::VideoCapture capture_;
  cv::Mat mat_;
  std::string letters_;
  double width_ = 0;
  double height_ = 0;
  double rate_ = kVideoRate;
  double media_ms_ = 0;
  double frames_ = 0;
  bool is_raw_ = false;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_capture(const DeviceAddress& address) {
  auto source = std::make_unique<CaptureSource>(address);
  if (auto opened = source->open(); !opened) return opened.error();
  return std::unique_ptr<FrameSource>(std::move(source));
}

}  // namespace rack::device

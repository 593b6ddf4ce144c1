// Heads, frames and JPEG pictures of any bytes, in any order: the camera's dialogue does not fail,
// and every picture can be sent and compressed by CameraJpeg. The same bytes as a parameter file.
#include <array>
#include <cmath>

#include "components/devices/camera/camera_frames.h"
#include "components/devices/camera/exposure_control.h"
#include "components/devices/camera/parameter_file.h"
#include "components/devices/camera/white_balance.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace rack::device;
using tims::fuzz::require;

constexpr std::array kModes = {
    rack::camera_mode::kJpeg,   rack::camera_mode::kMono8,     rack::camera_mode::kRgb24,
    rack::camera_mode::kYuv422, rack::camera_mode::kMono16,    rack::camera_mode::kRange,
    rack::camera_mode::kRange,  rack::camera_mode::kDisparity, rack::camera_mode::kMono12,
    rack::camera_mode::kRaw8,   rack::camera_mode::kRaw12,     rack::camera_mode::kRaw16};
constexpr std::array kKinds = {video::kHead,
                               video::kMjpeg,
                               video::kJpeg,
                               video::kGrey,
                               video::kYuyv,
                               video::kUyvy,
                               video::kRgb24,
                               video::kBgr24,
                               video::kGrey16,
                               video::kDepth16,
                               video::kControl,
                               video::kRggb,
                               video::kGbrg,
                               video::kGrbg,
                               video::kBggr,
                               video::kRggb16,
                               video::kBggr16 | video::kBigEndian};

struct Camera : Output {
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    require(bytes.size() == 4 && id != 0);
  }
};

// For pictures that are twice as wide as high.
rack::pictures::CameraCalibration lens() {
  return {.width = 8,
          .height = 4,
          .camera = {.fx = 6, .fy = 6, .cx = 4, .cy = 2},
          .distortion = {-0.3, 0.1, 0.01, 0, 0},
          .rectified = {.fx = 5, .fy = 5, .cx = 3, .cy = 1}};
}

void check(const rack::CameraData& picture, PictureMaker& maker, rack::CameraData& small) {
  require(picture.width > 0 && picture.height > 0);
  require(picture.image.size() <= rack::kCameraBytesMax);
  require(static_cast<std::int64_t>(picture.image.size()) == picture.tail_sizes()[0]);
  if (picture.mode == rack::camera_mode::kJpeg) {
    const auto size = rack::pictures::jpeg_size(picture.image);
    require(size && size->width == picture.width && size->height == picture.height);
  }
  if (!maker.compress(picture, small)) return;
  require(small.mode == rack::camera_mode::kJpeg);
  require(small.width == picture.width && small.height == picture.height);
}

}  // namespace

// Values below 16 of the first byte: as CameraV4l has it; others: as CameraDcam.
void add_controls(CameraFrames& camera, std::uint8_t first, std::uint8_t settings) {
  if (first < 16) return;
  camera.add(std::make_unique<ExposureControl>(
      ExposureSettings{.dark_max = settings, .part = settings % 5, .shutter = settings % 3 - 1}));
  camera.add(std::make_unique<WhiteBalanceControl>(WhiteBalanceSettings{
      .method = static_cast<WhiteBalance>(settings % 3), .columns = settings, .lines = first}));
}

void check_parameters(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  rack::CameraParamData all;
  (void)add_parameters(text, all);
  require(std::isfinite(all.fx.raw()) && std::isfinite(all.coordinateRotation[8]));
}

// Input: mode, settings, then frames: kind, length (2 bytes), bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  auto bytes = std::as_bytes(std::span(data, size)).subspan(2);
  const bool has_two_eyes = (data[1] & 1) != 0;
  check_parameters(bytes);
  CameraFrames camera({.mode = kModes.at(data[0] % 16 % kModes.size()),
                       .quality = 1 + data[1] % 100,
                       .thinning = 1 + data[0] / 16 % 4,
                       .focal = has_two_eyes ? 100.0 : 0,
                       .base = has_two_eyes ? 60.0 : 0,
                       .stereo = {.disparities = 8 + data[1] % 16, .block = 3 + data[1] / 64 * 2},
                       .calibration = data[1] >= 0xF0 ? std::optional(lens()) : std::nullopt});
  add_controls(camera, data[0], data[1]);
  Camera output;
  Time now(std::chrono::seconds(1));
  static PictureMaker maker;
  static rack::CameraData small;
  rack::CameraData picture;
  Time recorded;
  camera.start(now, output);
  while (bytes.size() >= 3) {
    const std::uint32_t kind = kKinds.at(std::to_integer<std::size_t>(bytes[0]) % kKinds.size());
    const auto length =
        std::to_integer<std::size_t>(bytes[1]) | std::to_integer<std::size_t>(bytes[2]) << 8;
    bytes = bytes.subspan(3);
    const auto frame = bytes.first(std::min(length, bytes.size()));
    bytes = bytes.subspan(frame.size());
    now += std::chrono::milliseconds(30);
    camera.on_arrival({.bytes = frame, .first = now, .last = now, .id = kind}, output);
    if (camera.take(picture, recorded)) check(picture, maker, small);
    if (camera.next_timeout() <= now) camera.on_timeout(now, output);
    if (camera.failure()) camera.start(now, output);
  }
  return 0;
}

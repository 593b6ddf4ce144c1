// CameraV4l: driver of a V4L2 camera, and of other sources of pictures: videos, streams, pipelines.
#include <filesystem>

#include "components/devices/drivers/calibrated_camera.h"
#include "components/devices/drivers/camera_driver.h"
#include "components/devices/io/transports.h"
#include "components/pictures/opencv_call.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 20>{{
    {"width", 320, "width of the picture [pixels]; the camera may choose a similar one", 1, 65535},
    {"height", 240, "height [pixels]", 1, 65535},
    {"depth", 24, "depth of a pixel [bit]; determined by mode", 8, 24},
    one_of("mono8, mono16, rgb24, yuv422, raw8, raw16, jpeg, range, disparity",
           {"mode", "rgb24", "format of the pictures"}),
    {"videoId", 0, "number N of the camera /dev/videoN", 0, 255},
    {"minHue", 15, "increase the brightness below this mean value, 0 to 255", 0, 255},
    {"maxHue", 250, "decrease the brightness above this mean value, 0 to 255", 0, 255},
    {"gainMult", 1000, "gain of the brightness control [1/1000]", 0, 100000},
    {"autoBrightnessSize", 1, "evaluated area: 1 whole picture, n 1/n of each side, 0 control off",
     0, 64},
    {"fps", 5, "pictures per second [1/s]", 1, 1000},
    {"quality", 75, "JPEG quality of mode jpeg, if the camera does not compress", 1, 100},
    {"stereoBase", 0.0F, "base line of a side-by-side stereo camera [mm]; 0: monocular", 0, 1e5},
    {"stereoDisparities", 64, "disparity search range [pixels]", 8, 512},
    {"stereoBlock", 9, "side of the matching block, odd [pixels]", 5, 31},
    one_of("block (fast; bare walls are unknown), semiglobal (fills them)",
           {"stereoMethod", "block", "method of stereo matching"}),
    {"fx", 0.0F, "focal length in x (one lens of a stereo camera) [pixels]; 0: unknown", 0, 1e6},
    {"fy", 0.0F, "focal length in y [pixels]", 0, 1e6},
    {"e0", 0.0F, "principal point, x [pixels]", 0, 1e6},
    {"n0", 0.0F, "principal point, y [pixels]", 0, 1e6},
    host_file({"calibration", "",
               "rectify pictures by this file of camera-calibrate or ROS (.yaml); it contains fx, "
               "fy, e0, n0"}),
}});

constexpr ModuleInfo kInfo{
    .program = "CameraV4l",
    .purpose =
        "A V4L2 camera: webcam, frame grabber, depth camera or side-by-side stereo camera. Or "
        "--device=: a video file, a folder of pictures, an RTSP or HTTP stream, a GStreamer "
        "pipeline.",
    .class_id = tims::class_id::kCamera,
    .parameters = kParameters,
};

class CameraV4l : public CameraDriver {
 public:
  CameraV4l() : CameraDriver(kInfo) { pictures::use_one_thread(); }

 private:
  Result<DeviceOptions> device() const override {
    const auto format = wanted();
    if (!format) return format.error();
    auto address = address_for(*format);
    if (!address) return address.error();
    return DeviceOptions{.address = *address, .record = text("record")};
  }

  Result<DeviceAddress> address_for(const CameraFormat& format) const {
    const std::string text_of_it = text("device");
    auto address = DeviceAddress::parse(
        text_of_it.empty() ? "v4l:/dev/video" + std::to_string(integer("videoId")) : text_of_it);
    std::error_code none;
    if (address && address->kind == TransportKind::kFile &&
        std::filesystem::is_directory(address->place, none))
      address->options.try_emplace("rate", std::to_string(integer("fps")));
    if (!address || address->kind != TransportKind::kVideo) return address;
    const bool is_pair = real("stereoBase") > 0;
    const i32 width = is_pair ? 2 * format.width : format.width;
    auto& options = address->options;
    options.try_emplace("size", std::to_string(width) + "x" + std::to_string(format.height));
    options.try_emplace("format", formats_for(format.mode));
    options.try_emplace("rate", std::to_string(integer("fps")));
    return address;
  }

  Result<std::unique_ptr<CameraFrames>> make_dialogue() override {
    const auto format = wanted();
    if (!format) return format.error();
    if (integer("stereoBlock") % 2 == 0) return refused("stereoBlock must be odd");
    const std::string method = text("stereoMethod");
    if (method != "block" && method != "semiglobal")
      return refused("stereoMethod must be block or semiglobal, not " + method);
    auto calibration = load_calibration(*format);
    if (!calibration) return calibration.error();
    const auto period = std::chrono::milliseconds(1000 / integer("fps"));
    set_period(period);
    return std::make_unique<CameraFrames>(CameraSettings{
        .mode = format->mode,
        .quality = integer("quality"),
        .first_within = first_within(),
        .period = is_recording() ? std::chrono::milliseconds(0) : period,
        .brightness_min = integer("minHue"),
        .brightness_max = integer("maxHue"),
        .brightness_gain = integer("gainMult"),
        .brightness_part = integer("autoBrightnessSize"),
        .focal = real("fx"),
        .base = real("stereoBase"),
        .stereo = {.disparities = integer("stereoDisparities"),
                   .block = integer("stereoBlock"),
                   .method = method == "block" ? StereoMethod::kBlock : StereoMethod::kSemiGlobal},
        .calibration = std::move(*calibration)});
  }

  // Cameras at the bus answer at once. Others have limits of their own, with better reasons.
  [[nodiscard]] Duration first_within() const {
    const auto address = DeviceAddress::parse(text("device"));
    const bool is_at_bus = !address || address->kind == TransportKind::kVideo;
    return std::chrono::seconds(is_at_bus ? 5 : 15);
  }

  Result<std::optional<pictures::CameraCalibration>> load_calibration(const CameraFormat& format) {
    const std::string file = text("calibration");
    if (file.empty()) return std::optional<pictures::CameraCalibration>();
    if (auto possible = check_rectified(format); !possible) return possible.error();
    auto calibration = calibrated_.load(file);
    if (!calibration) return calibration.error();
    const CameraParamData given = given_intrinsics(format);
    if (given.fx == 0 && given.fy == 0 && given.e0 == 0 && given.n0 == 0)
      return std::optional(*calibration);
    const auto known = rectified_intrinsics(*calibration, format.width, format.height);
    if (!known) return known.error();
    if (auto same = check_intrinsics(given, *known); !same) return same.error();
    return std::optional(*calibration);
  }

  [[nodiscard]] Result<void> check_rectified(const CameraFormat& format) const {
    if (text("calibration").empty()) return {};
    if (real("stereoBase") > 0)
      return refused(
          "calibration is that of one lens: pictures of a stereo camera are not rectified");
    if (!can_rectify(format.mode))
      return refused("mode " + std::string(name_of_mode(format.mode)) +
                     " is not rectified: set calibration to an empty text");
    return {};
  }

  Result<void> complete(CameraData& data) override {
    calibrated_.set_size(data.width.raw(), data.height.raw());
    return {};
  }

  [[nodiscard]] Result<CameraParamData> calibration() const override {
    const CameraFormat format = wanted().value_or(CameraFormat{});
    const std::string file = text("calibration");
    if (file.empty()) return given_intrinsics(format);
    return calibrated_.intrinsics(file, format.width, format.height);
  }

  [[nodiscard]] CameraParamData given_intrinsics(const CameraFormat& format) const {
    CameraParamData data;
    data.calibration_width = format.width;
    data.calibration_height = format.height;
    data.fx = real("fx");
    data.fy = real("fy");
    data.e0 = real("e0");
    data.n0 = real("n0");
    data.coordinateRotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    return data;
  }

  [[nodiscard]] Result<CameraFormat> of_parameters() const override {
    const auto mode = mode_of(text("mode"));
    if (!mode)
      return refused(
          "mode must be mono8, mono16, rgb24, yuv422, raw8, raw16, jpeg, range or disparity, not " +
          text("mode"));
    return CameraFormat{integer("width"), integer("height"), *mode};
  }

  [[nodiscard]] Result<CameraFormat> possible(const CameraFormat& format) const override {
    if (auto rectified = check_rectified(format); !rectified) return rectified.error();
    auto address = address_for(format);
    if (!address) return address.error();
    const bool has_two_eyes = real("stereoBase") > 0 && real("fx") > 0;
    if (format.mode == camera_mode::kRange && !has_two_eyes) address->options["format"] = "Z16";
    if (address->kind == TransportKind::kVideo)
      if (auto has = check_video(*address); !has) return has.error();
    return format;
  }

  CalibratedCamera calibrated_;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::CameraV4l camera;
  return camera.run(argc, argv);
}

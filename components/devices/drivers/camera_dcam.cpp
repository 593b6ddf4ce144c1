// CameraDcam: driver of an IIDC camera (FireWire, and USB cameras with the same registers).
#include "components/devices/camera/exposure_control.h"
#include "components/devices/camera/parameter_file.h"
#include "components/devices/camera/white_balance.h"
#include "components/devices/drivers/camera_driver.h"
#include "components/devices/io/transports.h"
#include "components/pictures/opencv_call.h"
#include "os/file.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 22>{{
    {"cameraGuid", "0", "GUID of the camera, decimal or 0x...; 0: the first one"},
    one_of("mono8, mono12, mono16, rgb24, yuv422, raw8, raw12, raw16, jpeg",
           {"mode", "yuv422", "format of the pictures"}),
    {"width", 1280, "width of the camera's frames, which must have this size [pixels]", 1, 65535},
    {"height", 960, "height [pixels]", 1, 65535},
    {"fps", 10, "pictures per second [1/s]", 1, 240},
    {"lossrate", 1, "publish every n-th pixel in both directions", 1, pictures::kThinningMax},
    one_of("100, 200, 400, 800", {"isoSpeed", 400, "speed of the bus [Mbit/s]", 100, 3200}),
    {"quality", 75, "JPEG quality of mode jpeg", 1, 100},
    {"autoBrightnessSize", 1,
     "evaluated lines: the lowest 1/n; 0: shutter and gain are fixed or set by the camera", 0, 64},
    {"minHue", 60, "pixels up to this value are too dark, 0 to 255", 0, 255},
    {"maxHue", 250, "pixels from this value on are too bright, 0 to 255", 0, 255},
    {"shutterMult", 64, "change of the shutter if all pixels are too dark", 0, 100000},
    {"gainMult", 16, "change of the gain if all pixels are too dark", 0, 100000},
    {"shutter", -1, "fixed shutter if autoBrightnessSize is 0; -1: by the camera", -1, 1000000},
    {"gain", -1, "fixed gain if autoBrightnessSize is 0; -1: by the camera", -1, 1000000},
    one_of("0 uValue and vValue, 1 from there by a grey surface at the upper edge, 2 by the camera",
           {"whitebalanceMode", 1, "white balance", 0, 2}),
    {"uValue", 150, "white balance, blue", 0, 1000000},
    {"vValue", 120, "white balance, red", 0, 1000000},
    {"whitebalanceCols", 20, "half of the width of the grey surface [pixels]; 0: none", 0, 10000},
    {"whitebalanceRows", 10, "height of the grey surface [pixels]; 0: none", 0, 10000},
    host_file({"intrParFile", "", "file of intrinsic parameters, without _lrN.cal (N: lossrate)"}),
    host_file({"extrParFile", "", "file of extrinsic parameters, without .cal"}),
}});

constexpr ModuleInfo kInfo{
    .program = "CameraDcam",
    .purpose = "An IIDC camera: FireWire, or USB with the same registers (libdc1394).",
    .class_id = tims::class_id::kCamera,
    .parameters = kParameters,
};

class CameraDcam : public CameraDriver {
 public:
  CameraDcam() : CameraDriver(kInfo) { pictures::use_one_thread(); }

 private:
  Result<DeviceOptions> device() const override {
    const auto format = wanted();
    if (!format) return format.error();
    auto address = address_for(format->mode);
    if (!address) return address.error();
    return DeviceOptions{.address = *address, .record = text("record"), .open_dcam = &open_dcam};
  }

  Result<DeviceAddress> address_for(u16 mode) const {
    const std::string given = text("device");
    auto address = given.empty() ? dcam_device(text("cameraGuid")) : DeviceAddress::parse(given);
    if (!address || address->kind != TransportKind::kDcam) return address;
    auto& options = address->options;
    options.try_emplace("size",
                        std::to_string(integer("width")) + "x" + std::to_string(integer("height")));
    options.try_emplace("format", formats_for(mode));
    options.try_emplace("rate", std::to_string(integer("fps")));
    options.try_emplace("speed", std::to_string(integer("isoSpeed")));
    return address;
  }

  Result<std::unique_ptr<CameraFrames>> make_dialogue() override {
    const auto format = wanted();
    if (!format) return format.error();
    if (auto loaded = load_calibration(*format); !loaded) return loaded.error();
    const auto period = std::chrono::milliseconds(1000 / integer("fps"));
    set_period(period);
    auto frames = std::make_unique<CameraFrames>(
        CameraSettings{.mode = format->mode,
                       .quality = integer("quality"),
                       .thinning = thinning_for(*format),
                       .period = is_recording() ? std::chrono::milliseconds(0) : period});
    // Of numbers with 16 bits, the camera uses some: their brightness is not known.
    const bool is_wide = depth_of(format->mode) == 16 && format->mode != camera_mode::kYuv422;
    frames->add(std::make_unique<ExposureControl>(
        ExposureSettings{.dark_max = integer("minHue"),
                         .bright_min = integer("maxHue"),
                         .gain_factor = integer("gainMult"),
                         .shutter_factor = integer("shutterMult"),
                         .part = is_wide ? 0 : integer("autoBrightnessSize"),
                         .shutter = integer("shutter"),
                         .gain = integer("gain")}));
    frames->add(std::make_unique<WhiteBalanceControl>(
        WhiteBalanceSettings{.method = static_cast<WhiteBalance>(integer("whitebalanceMode")),
                             .blue = integer("uValue"),
                             .red = integer("vValue"),
                             .columns = integer("whitebalanceCols"),
                             .lines = integer("whitebalanceRows")}));
    return frames;
  }

  [[nodiscard]] Result<CameraFormat> of_parameters() const override {
    const auto mode = mode_of(text("mode"));
    if (!mode || *mode == camera_mode::kRange || *mode == camera_mode::kDisparity)
      return refused(
          "mode must be mono8, mono12, mono16, rgb24, yuv422, raw8, raw12, raw16 or jpeg, not " +
          text("mode"));
    return reduced(integer("lossrate"), *mode);
  }

  [[nodiscard]] CameraFormat reduced(int thinning, u16 mode) const {
    return {integer("width") / thinning, integer("height") / thinning, mode};
  }

  [[nodiscard]] int thinning_for(const CameraFormat& format) const {
    const int own = integer("lossrate");
    if (format == reduced(own, format.mode)) return own;
    return integer("width") / format.width;
  }

  // As in the original, the width determines the height.
  [[nodiscard]] Result<CameraFormat> possible(const CameraFormat& format) const override {
    const int thinning = integer("width") / format.width;
    if (thinning < 1 || thinning > pictures::kThinningMax)
      return refused("width must be " + std::to_string(integer("width") / pictures::kThinningMax) +
                     " to " + std::to_string(integer("width")) + " pixels");
    if (format.mode == camera_mode::kRange || format.mode == camera_mode::kDisparity)
      return refused("not a depth camera");
    const auto address = address_for(format.mode);
    if (!address) return address.error();
    if (address->kind == TransportKind::kDcam)
      if (auto has = check_dcam(*address); !has) return has.error();
    return reduced(thinning, format.mode);
  }

  [[nodiscard]] Result<CameraParamData> calibration() const override {
    const std::lock_guard lock(calibration_mutex_);
    return calibration_;
  }

  // The files of the original are for one lossrate and one size.
  Result<void> load_calibration(const CameraFormat& format) {
    CameraParamData data;
    data.coordinateRotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const auto add = [&](std::string_view parameter, const std::string& ending) -> Result<void> {
      if (text(parameter).empty()) return {};
      const std::string path = text(parameter) + ending;
      const auto read = tims::os::read_file(path, kParameterFileMax);
      if (!read) return refused(std::string(parameter) + ": " + read.error().detail());
      const auto added = add_parameters(*read, data);
      return added ? added : refused(path + ", " + added.error().detail());
    };
    const std::string reduction = "_lr" + std::to_string(thinning_for(format)) + ".cal";
    if (auto added = add("intrParFile", reduction); !added) return added;
    if (auto added = add("extrParFile", ".cal"); !added) return added;
    if (data.calibration_width == 0) data.calibration_width = format.width;
    if (data.calibration_height == 0) data.calibration_height = format.height;
    if (data.calibration_width != format.width || data.calibration_height != format.height)
      return refused("intrParFile is for pictures of " +
                     std::to_string(data.calibration_width.raw()) + "x" +
                     std::to_string(data.calibration_height.raw()) + " pixels, not " +
                     std::to_string(format.width) + "x" + std::to_string(format.height));
    const std::lock_guard lock(calibration_mutex_);
    calibration_ = data;
    return {};
  }

  mutable std::mutex calibration_mutex_;
  CameraParamData calibration_{};
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::CameraDcam camera;
  return camera.run(argc, argv);
}

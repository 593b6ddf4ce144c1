// CameraJpeg: compresses the pictures of another camera.
#include <array>
#include <mutex>
#include <optional>

#include "components/devices/camera/picture.h"
#include "components/pictures/opencv_call.h"
#include "rack/data_module.h"
#include "rack/input.h"

namespace rack::device {
namespace {

constexpr std::array<ParameterInfo, 2> kParameters = {{
    partner("camera", "the camera"),
    {"quality", 50, "JPEG quality: 1 (smallest) to 100 (best)", 1, 100},
}};

constexpr ModuleInfo kInfo{
    .program = "CameraJpeg",
    .purpose = "Pictures of another camera (mono8, rgb24, yuv422) as JPEG.",
    .class_id = tims::class_id::kCamera,
    .parameters = kParameters,
};

class CameraJpeg : public DataModule<CameraData> {
 public:
  CameraJpeg() : DataModule(kInfo, {.history = 4}) {
    pictures::use_one_thread();
    picture_.image.reserve_all();
  }

 private:
  Result<void> module_on() override {
    maker_.emplace(integer("quality"));
    if (camera_.address() == address())
      return refused("cameraInst must not be this component itself");
    if (auto on = camera_.turn_on(); !on) return on;
    keep(camera_->get_parameter());
    const auto granted = camera_.subscribe();
    if (!granted) return granted.error();
    set_period(*granted);
    return DataModule::module_on();
  }

  void module_off() override { camera_.stop(); }

  Result<void> module_loop() override {
    if (auto come = camera_.next(picture_, 5 * period()); !come) return come;
    if (auto made = maker_->compress(picture_, get_local_buffer()); !made) return made;
    return put_local_buffer();
  }

  // Compression does not change the geometry: the calibration is that of the camera.
  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != CameraType::kGetParameter)
      return DataModule::module_command(message);
    const std::lock_guard lock(calibration_mutex_);
    if (!calibration_) return refused("the camera has not sent its calibration");
    reply(message.header, CameraType::kParameter, *calibration_);
    return {};
  }

  void keep(const Result<CameraParamData>& calibration) {
    const std::lock_guard lock(calibration_mutex_);
    if (calibration)
      calibration_ = *calibration;
    else
      calibration_.reset();
  }

  OwnMailbox work_{*this, 1, wire_size<CameraParamData>()};
  Input<CameraProxy> camera_{*this, "camera", work_, 1, body_max<CameraData>()};
  std::optional<PictureMaker> maker_;
  CameraData picture_;
  std::mutex calibration_mutex_;
  std::optional<CameraParamData> calibration_;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::CameraJpeg camera;
  return camera.run(argc, argv);
}

// Scan2d: the scans of a ladar as points in the robot's frame.
#include <algorithm>
#include <array>
#include <chrono>

#include "components/geometry/pose.h"
#include "components/scan2d/ladar_scan.h"
#include "components/scan2d/picture_intensity.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/position.h"

namespace rack::scan2d {
namespace {

// The parameters of the original in its order; behind them the pose of a camera and the odometry
// for the robot's movement during a scan.
constexpr std::array<ParameterInfo, 22> kParameters = {{
    required_partner("ladar", "the ladar"),
    optional_partner("camera", "the camera",
                     "the camera for intensities (set at the start); -1: none"),
    optional_partner("position", "the position", "the position, for refPos; -1: none"),
    {"ladarOffsetX", 0, "position of the ladar on the robot, forward [mm]"},
    {"ladarOffsetY", 0, "the same to the right [mm]"},
    {"ladarOffsetRho", 0, "heading of the ladar [deg / ladarOffsetRhoDivider]"},
    {"ladarOffsetRhoDivider", 1, "divisor of ladarOffsetRho, for fractions of degrees", 1, 1e6},
    {"ladarUpsideDown", 0, "1: the ladar is mounted upside down", 0, 1},
    {"maxRange", 30000, "maximum range [mm]", 1, 1e9},
    {"reduce", 1, "use every n-th point", 1, 10000},
    {"angleMin", -180, "minimum angle of the ladar if mounted upright [deg]", -360, 360},
    {"angleMax", 180, "maximum angle of the ladar if mounted upright [deg]", -360, 360},
    {"reflectorFilterMode", 0, "1: do not report walls seen at a right angle as reflectors", 0, 1},
    {"medianFilter", 0, "1: remove single outliers by a median filter", 0, 1},
    {"cameraX", 0, "position of the camera on the robot, forward [mm]"},
    {"cameraY", 0, "the same to the right [mm]"},
    {"cameraZ", 0, "below the plane of the ladar [mm]; above it: negative"},
    {"cameraPhi", 0.0F, "roll of the camera to the right [deg]", -360, 360},
    {"cameraPsi", 0.0F, "pitch of the camera upwards [deg]", -360, 360},
    {"cameraRho", 0.0F, "heading of the camera, clockwise [deg]", -360, 360},
    optional_partner("odometry", "the odometry",
                     "the odometry, to correct points for the movement during a scan; -1: none"),
    {"ladarReversed", 0, "1: the last point is measured first (SICK LMS200, S300)", 0, 1},
}};

constexpr u32 kLongest = 10000;  // ms, maximum duration of a scan
constexpr std::chrono::milliseconds kAtLeast{
    50};  // long enough to reduce rounding errors of mm and ms

constexpr ModuleInfo kInfo{
    .program = "Scan2d",
    .purpose = "Converts the scans of a ladar to points in the robot's frame.",
    .class_id = tims::class_id::kScan2d,
    .parameters = kParameters,
};

class Scan2d : public DataModule<Scan2dData> {
 public:
  Scan2d() : DataModule(kInfo, {.history = 10}) { reserve_all(ladar_data_); }

 private:
  Result<void> module_init() override {
    if (!camera_.is_named()) return {};
    picture_.image.reserve_all();
    work_.set_body_max(body_max<CameraData>());
    return {};
  }

  Result<void> module_on() override {
    read_parameters();
    const auto granted = ladar_.start();
    if (!granted) return granted.error();
    set_period(*granted);
    camera_.connect();
    if (camera_) {
      if (picture_.image.capacity() == 0)
        return refused("cameraInst can only be set when Scan2d is started");
      if (auto on = camera_->on(); !on) return on;
      view_ = camera_view();
    }
    get_local_buffer().refPos = {};
    if (auto on = position_.turn_on(); !on) return on;
    if (auto on = odometry_.turn_on(); !on) return on;
    return DataModule::module_on();
  }

  // For a ladar with a camera interface, no focal length is needed.
  Result<CameraView> camera_view() {
    const auto camera = camera_->get_parameter();
    if (!camera) return camera.error();
    const auto angle = [this](std::string_view name) {
      return radians(static_cast<double>(real(name)));
    };
    return CameraView::make(*camera, {.x = static_cast<double>(integer("cameraX")),
                                      .y = static_cast<double>(integer("cameraY")),
                                      .z = static_cast<double>(integer("cameraZ")),
                                      .phi = angle("cameraPhi"),
                                      .psi = angle("cameraPsi"),
                                      .rho = angle("cameraRho")});
  }

  void read_parameters() {
    mounting_ = {.x = integer("ladarOffsetX"),
                 .y = integer("ladarOffsetY"),
                 .rho = radians(static_cast<double>(integer("ladarOffsetRho")) /
                                integer("ladarOffsetRhoDivider")),
                 .upside_down = integer("ladarUpsideDown") != 0,
                 .is_reversed = integer("ladarReversed") != 0};
    // Half a thousandth of a degree more, so that the limits are included.
    filter_ = {.range_max = integer("maxRange"),
               .reduce = integer("reduce"),
               .angle_min = radians(integer("angleMin") - 0.0005),
               .angle_max = radians(integer("angleMax") + 0.0005),
               .median = integer("medianFilter") != 0,
               .reflectors = integer("reflectorFilterMode") != 0};
  }

  void module_off() override { ladar_.stop(); }

  Result<void> module_loop() override {
    // As long as drivers wait for a device; pilots stop much earlier.
    constexpr std::chrono::milliseconds kSilenceMin{200};
    const auto patience = std::max<std::chrono::milliseconds>(3 * period(), kSilenceMin);
    if (auto come = ladar_.next(ladar_data_, patience); !come) return come;
    Scan2dData& scan = get_local_buffer();
    const auto motion = motion_of_scan();
    if (!motion) return motion.error();
    convert(ladar_data_, mounting_, filter_, scan, *motion);
    if (position_) {
      const auto position = position_->get_data(scan.recordingTime);
      if (!position) return position.error();
      scan.refPos = position->pos;
    }
    if (camera_) {
      if (auto seen = camera_->get_data(picture_, scan.recordingTime); !seen) return seen;
      if (auto added = add_picture(scan); !added) return added;
    }
    return put_local_buffer();
  }

  // Uses the time before the middle of the scan, for which the odometry surely has data. If it has
  // just started, no movement is assumed.
  Result<Pose> motion_of_scan() {
    if (!odometry_ || ladar_data_.duration == 0) return Pose{};
    const std::chrono::milliseconds during(std::min<u32>(ladar_data_.duration, kLongest));
    const TimeStamp time = ladar_data_.recordingTime;
    const auto now = odometry_->get_data(time);
    const auto before = odometry_->get_data(time - std::max(during, kAtLeast));
    for (const auto* one : {&now, &before}) {
      if (*one) continue;
      if (one->error().code() == tims::Errc::kAnsweredError) return Pose{};
      return one->error();
    }
    return motion_during_scan(
        Pose::of(before->pos), Pose::of(now->pos),
        static_cast<double>((now->recordingTime - before->recordingTime).count()),
        static_cast<double>(ladar_data_.duration.raw()));
  }

  Result<void> add_picture(Scan2dData& scan) {
    if (picture_.width == 1 || picture_.height == 1) return add_intensities(picture_, scan);
    if (!view_) return view_.error();
    Pose moved;
    if (position_) {
      const auto then = position_->get_data(picture_.recordingTime);
      if (!then) return then.error();
      moved = Pose::of(scan.refPos) - Pose::of(then->pos);
    }
    return view_->add_brightness(picture_, moved, scan);
  }

  OwnMailbox work_{*this, 1, kReasonMax};
  Input<LadarProxy> ladar_{*this, "ladar", work_, 1, body_max<LadarData>()};
  Partner<CameraProxy> camera_{*this, "camera", work_};
  Result<CameraView> view_ = refused("the camera was not queried yet");
  Partner<PositionProxy> position_{*this, "position", work_};
  Partner<OdometryProxy> odometry_{*this, "odometry", work_};
  LadarData ladar_data_;
  CameraData picture_;
  LadarMounting mounting_;
  ScanFilter filter_;
};

}  // namespace
}  // namespace rack::scan2d

int main(int argc, char** argv) {
  rack::scan2d::Scan2d scan;
  return scan.run(argc, argv);
}

// Scan2d: the scans of a ladar as points in the robot's frame.
#include <algorithm>
#include <array>
#include <chrono>
#include <optional>

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
constexpr std::array<ParameterInfo, 26> kParameters = {{
    {"ladarSys", 0, "system id of the ladar", 0, kIdMax},
    {"ladarInst", 0, "instance of the ladar", 0, kIdMax, true},
    {"cameraSys", 0, "system id of the camera", 0, kIdMax},
    {"cameraInst", -1, "instance of the camera for intensities (set at the start); -1: none", -1,
     kIdMax},
    {"positionSys", 0, "system id of the position", 0, kIdMax},
    {"positionInst", -1, "instance of the position, for refPos; -1: none", -1, kIdMax},
    {"ladarOffsetX", 0, "position of the ladar on the robot, mm forward"},
    {"ladarOffsetY", 0, "mm to the right"},
    {"ladarOffsetRho", 0, "heading of the ladar, deg / ladarOffsetRhoDivider"},
    {"ladarOffsetRhoDivider", 1, "divisor of ladarOffsetRho, for fractions of degrees", 1, 1e6},
    {"ladarUpsideDown", 0, "1: the ladar is mounted upside down", 0, 1},
    {"maxRange", 30000, "maximum range, mm", 1, 1e9},
    {"reduce", 1, "use every n-th point", 1, 10000},
    {"angleMin", -180, "minimum angle of the ladar if mounted upright, deg", -360, 360},
    {"angleMax", 180, "maximum angle of the ladar if mounted upright, deg", -360, 360},
    {"reflectorFilterMode", 0, "1: do not report walls seen at a right angle as reflectors", 0, 1},
    {"medianFilter", 0, "1: remove single outliers by a median filter", 0, 1},
    {"cameraX", 0, "position of the camera on the robot, mm forward"},
    {"cameraY", 0, "mm to the right"},
    {"cameraZ", 0, "below the plane of the ladar, mm; above it: negative"},
    {"cameraPhi", 0.0F, "roll of the camera to the right, deg", -360, 360},
    {"cameraPsi", 0.0F, "pitch of the camera upwards, deg", -360, 360},
    {"cameraRho", 0.0F, "heading of the camera, clockwise, deg", -360, 360},
    {"odometrySys", 0, "system id of the odometry", 0, kIdMax},
    {"odometryInst", -1,
     "instance of the odometry, to correct points for the movement during a scan; -1: none", -1,
     kIdMax},
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
    const bool has_camera = integer("cameraInst") >= 0;
    if (has_camera) picture_.image.reserve_all();
    const std::uint32_t answer_max = has_camera ? body_max<CameraData>() : kReasonMax;
    if (auto made = create_mailbox(work_, 1, answer_max); !made) return made;
    return create_input(ladar_, *work_, 1, body_max<LadarData>());
  }

  Result<void> module_on() override {
    read_parameters();
    const auto granted = ladar_->start(address_of(tims::class_id::kLadar, "ladar"));
    if (!granted) return granted.error();
    set_period(*granted);
    camera_.reset();
    if (integer("cameraInst") >= 0) {
      if (picture_.image.capacity() == 0)
        return refused("cameraInst can only be set when Scan2d is started");
      camera_.emplace(*work_, address_of(tims::class_id::kCamera, "camera"));
      if (auto on = camera_->on(); !on) return on;
      view_ = camera_view();
    }
    get_local_buffer().refPos = {};
    if (auto on = turn_on_if_named(position_, *work_, tims::class_id::kPosition, "position"); !on)
      return on;
    if (auto on = turn_on_if_named(odometry_, *work_, tims::class_id::kOdometry, "odometry"); !on)
      return on;
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

  void module_off() override { ladar_->stop(); }

  Result<void> module_loop() override {
    // As long as drivers wait for a device; pilots stop much earlier.
    constexpr std::chrono::milliseconds kSilenceMin{200};
    const auto patience = std::max<std::chrono::milliseconds>(3 * period(), kSilenceMin);
    if (auto come = ladar_->next(ladar_data_, patience); !come) return come;
    Scan2dData& scan = get_local_buffer();
    const auto way = way_of_scan();
    if (!way) return way.error();
    convert(ladar_data_, mounting_, filter_, scan, *way);
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
  Result<Pose> way_of_scan() {
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
    return way_during_scan(
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
    return add_brightness(*view_, picture_, moved, scan);
  }

  tims::Mailbox* work_ = nullptr;
  std::optional<Input<LadarProxy>> ladar_;
  std::optional<CameraProxy> camera_;
  Result<CameraView> view_ = refused("the camera was not queried yet");
  std::optional<PositionProxy> position_;
  std::optional<OdometryProxy> odometry_;
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

// PilotWallFollowing: drives along walls.
#include <array>
#include <optional>

#include "components/geometry/pose.h"
#include "components/pilot/wall_follower.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/position.h"

namespace rack::pilot {
namespace {

constexpr std::array<ParameterInfo, 8> kParameters = {{
    required_partner("scan2d", "the scan"),
    partner("chassis", "the chassis"),
    partner("position", "the position"),
    {"maxSpeed", 500, "maximum speed [mm/s]", 0, 1e6},
    {"omegaMax", 20, "maximum angular speed [deg/s]", 0, 3600},
    one_of("0 keep the wall on the right, 1 follow near walls and turn away from obstacles",
           {"mode", 1, "behaviour", 0, 1}),
    {"distance", 1000, "distance to the wall [mm]", 1, 1e6},
    {"testDis", 1000, "mode 1: free distance required ahead [mm]", 1, 1e6},
}};

constexpr ModuleInfo kInfo{
    .program = "PilotWallFollowing",
    .purpose = "Drives along walls.",
    .class_id = tims::class_id::kPilot,
    .parameters = kParameters,
};

class PilotWallFollowing : public DataModule<PilotData> {
 public:
  PilotWallFollowing() : DataModule(kInfo, {.history = 5}) { reserve_all(scan_data_); }

 private:
  Result<void> module_on() override {
    if (auto on = chassis_.turn_on(); !on) return on;
    const auto limits = chassis_->get_parameter();
    if (!limits) return limits.error();
    follower_.emplace(settings(limits->vxMax), *limits);
    if (auto on = position_.turn_on(); !on) return on;
    const auto granted = scan_.start();
    if (!granted) return granted.error();
    set_period(*granted);
    return DataModule::module_on();
  }

  void module_off() override {
    if (chassis_) (void)chassis_->move(0, 0, 0);
    scan_.stop();
  }

  Result<void> module_loop() override {
    if (auto come = scan_.next(scan_data_, 2 * period()); !come) return come;
    double heading = 0;
    if (follower_->turns()) {
      const auto position = position_->get_data();
      if (!position) return position.error();
      heading = position->pos.rho;
    }
    const Drive drive = follower_->follow(scan_data_, period(), heading);
    if (auto moved = chassis_->move(drive.speed, 0, drive.omega); !moved) return moved;
    PilotData& data = get_local_buffer();
    data.recordingTime = scan_data_.recordingTime;
    data.speed = drive.speed;
    data.curve = drive.speed == 0 ? 0 : drive.omega / static_cast<f32>(drive.speed);
    data.distanceToDest = -1;
    return put_local_buffer();
  }

  [[nodiscard]] WallFollowerSettings settings(i32 chassis_speed_max) const {
    return {.mode = static_cast<WallFollowerSettings::Mode>(integer("mode")),
            .speed_max = std::min(integer("maxSpeed"), chassis_speed_max),
            .omega_max = radians(integer("omegaMax")),
            .distance = integer("distance"),
            .test_distance = integer("testDis")};
  }

  OwnMailbox work_{*this, 10, wire_size<ChassisParamData>()};
  Partner<ChassisProxy> chassis_{*this, "chassis", work_};
  Partner<PositionProxy> position_{*this, "position", work_};
  Input<Scan2dProxy> scan_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  Scan2dData scan_data_;
  std::optional<WallFollower> follower_;
};

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  rack::pilot::PilotWallFollowing pilot;
  return pilot.run(argc, argv);
}

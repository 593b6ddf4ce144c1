// PilotJoystick: drives by joystick and brakes for obstacles.
#include <array>

#include "components/pilot/drive.h"
#include "components/pilot/stick_watch.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/input.h"

namespace rack::pilot {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(100);
constexpr int kSilence = 10;  // periods without a message from an input

constexpr std::array<ParameterInfo, 10> kParameters = {{
    or_none(required_partner("scan2d", "the scan", "the scan; -1: no scan, no braking")),
    partner("chassis", "the chassis"),
    partner("joystick", "the joystick"),
    {"maxSpeed", 4000, "speed with the stick fully forward [mm/s]", 0, 1e6},
    {"maxSpeedSide", 0, "sideways speed with the third axis fully deflected [mm/s]", 0, 1e6},
    one_of("0 curvature, 1 angular speed", {"mode", 0, "meaning of the stick to the side", 0, 1}),
    {"chassisMinTurnRadius", 300, "minimum turning radius [mm]; the chassis may have a larger one",
     1, 1e6},
    {"joystickExpX", 0.0F, "exponent of the stick; above 0: finer near the centre", 0, 20},
    {"joystickExpY", 0.0F, "the same for the stick to the side", 0, 20},
    {"remoteTimeout", 300,
     "silence of a joystick in a browser or on another host after which the vehicle stands [ms]; "
     "after 1 s of silence of any joystick the pilot fails",
     100, 1000},
}};

constexpr ModuleInfo kInfo{
    .program = "PilotJoystick",
    .purpose = "Drives by joystick and brakes for obstacles.",
    .class_id = tims::class_id::kPilot,
    .parameters = kParameters,
};

class PilotJoystick : public DataModule<PilotData> {
 public:
  PilotJoystick() : DataModule(kInfo, {.history = 5}) { reserve_all(scan_data_); }

 private:
  Result<void> module_on() override {
    set_period(kPeriod);
    if (auto good = turn_on_chassis(); !good) return good;
    if (auto good = turn_on_joystick(); !good) return good;
    seen_ = false;
    watch_ = StickWatch(std::chrono::milliseconds(integer("remoteTimeout")), kPeriod);
    if (const auto scan = scan_.start(); !scan) return scan.error();
    return DataModule::module_on();
  }

  Result<void> turn_on_chassis() {
    if (auto on = chassis_.turn_on(); !on) return on;
    const auto limits = chassis_->get_parameter();
    if (!limits) return limits.error();
    limits_ = *limits;
    settings_ = {.speed_max = std::min(integer("maxSpeed"), limits_.vxMax.raw()),
                 .side_speed_max = std::min(integer("maxSpeedSide"), limits_.vyMax.raw()),
                 .turns_at_rest = integer("mode") == 1,
                 .turning_radius_min = integer("chassisMinTurnRadius"),
                 .x_exponent = real("joystickExpX"),
                 .y_exponent = real("joystickExpY")};
    return {};
  }

  Result<void> turn_on_joystick() {
    if (auto on = joystick_.turn_on(); !on) return on;
    if (auto asked = joystick_->get_data(stick_); !asked) return asked;
    const JoystickAxes& at = stick_.position;
    if (at.x != 0 || at.y != 0 || (settings_.side_speed_max > 0 && at.z != 0))
      return refused("the joystick is deflected; release it first");
    const auto granted = joystick_.subscribe();
    return granted ? Result<void>() : granted.error();
  }

  void module_off() override {
    if (chassis_) (void)chassis_->move(0, 0, 0);
    joystick_.stop();
    scan_.stop();
  }

  Result<void> module_loop() override {
    sleep_until_next(kPeriod);
    const auto moved_stick = joystick_.newest(stick_, kSilence);
    if (!moved_stick) return moved_stick.error();
    if (*moved_stick) watch_.heard(now(), joystick_.is_foreign());
    if (scan_) {
      const auto come = scan_.newest(scan_data_, kSilence);
      if (!come) return come.error();
      seen_ = seen_ || *come;
    }
    // Before the first scan, obstacles are unknown.
    Drive drive;
    if ((!scan_ || seen_) && !watch_.must_stand(now()))
      drive = joystick_drive(stick_, settings_, limits_, scan_ ? &scan_data_ : nullptr);
    // Chassis of the original use the second number as a limit; those that move sideways as a
    // speed.
    const i32 second = limits_.vyMax == 0 ? drive.speed_safe : drive.side;
    if (auto moved = chassis_->move(drive.speed, second, drive.omega); !moved) return moved;
    PilotData& data = get_local_buffer();
    data.recordingTime = time_stamp();
    describe(drive, limits_, data);
    return put_local_buffer();
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != PilotType::kSetDestination)
      return DataModule::module_command(message);
    return refused("a joystick pilot takes no destination");
  }

  OwnMailbox work_{*this, 10, wire_size<ChassisParamData>()};
  Partner<ChassisProxy> chassis_{*this, "chassis", work_};
  Input<JoystickProxy> joystick_{*this, "joystick", work_, 10, wire_size<JoystickData>()};
  Input<Scan2dProxy> scan_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  ChassisParamData limits_;
  JoystickDriveSettings settings_;
  JoystickData stick_;
  Scan2dData scan_data_;
  StickWatch watch_{{}, kPeriod};
  bool seen_ = false;
};

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  rack::pilot::PilotJoystick pilot;
  return pilot.run(argc, argv);
}

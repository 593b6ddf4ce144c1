// PilotLab: an example of a pilot. Copy it and replace LabCourse by your own course.
#include <array>
#include <mutex>
#include <optional>

#include "components/pilot/lab_course.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/position.h"

namespace rack::pilot {
namespace {

// The parameters of the original, in its order.
constexpr std::array<ParameterInfo, 9> kParameters = {{
    partner("chassis", "the chassis"),
    partner("position", "the position"),
    partner("scan2d", "the scan"),
    {"speedMax", 300, "maximum speed [mm/s]", 0, 1e6},
    {"vMaxSide", 0, "maximum sideways speed [mm/s]; 0: forward only", 0, 1e6},
    {"omegaMax", 30, "maximum angular speed [deg/s]", 0, 3600},
    {"varDistance", 1000, "distance to the destination from which it becomes slower [mm]", 1, 1e6},
    {"varRho", 15, "it drives when the destination is ahead within this angle [deg]", 1, 180},
    {"distanceMin", 300, "distance to obstacles ahead at which it stops [mm]", 0, 1e6},
}};

constexpr ModuleInfo kInfo{
    .program = "PilotLab",
    .purpose = "An example of a pilot: drives straight to its destination.",
    .class_id = tims::class_id::kPilot,
    .parameters = kParameters,
};

class PilotLab : public DataModule<PilotData> {
 public:
  PilotLab() : DataModule(kInfo, {.history = 5}) { reserve_all(scan_data_); }

 private:
  Result<void> module_on() override {
    if (auto on = chassis_.turn_on(); !on) return on;
    const auto limits = chassis_->get_parameter();
    if (!limits) return limits.error();
    if (auto on = position_.turn_on(); !on) return on;
    const auto granted = scan_.start();
    if (!granted) return granted.error();
    set_period(*granted);
    {
      const std::lock_guard lock(course_mutex_);
      course_.emplace(settings(), *limits);
    }
    return DataModule::module_on();
  }

  LabCourseSettings settings() const {
    return {.speed_max = integer("speedMax"),
            .side_speed_max = integer("vMaxSide"),
            .omega_max = radians(integer("omegaMax")),
            .slow_distance = integer("varDistance"),
            .heading_error = radians(integer("varRho")),
            .obstacle_distance = integer("distanceMin")};
  }

  void module_off() override {
    if (chassis_) (void)chassis_->move(0, 0, 0);
    scan_.stop();
  }

  // Once per scan: reads the inputs, decides, commands the chassis, publishes.
  Result<void> module_loop() override {
    if (auto come = scan_.next(scan_data_, 2 * period()); !come) return come;
    const auto position = position_->get_data();
    if (!position) return position.error();
    const Pose at = Pose::of(position->pos);
    Drive drive;
    {
      const std::lock_guard lock(course_mutex_);
      drive = course_->go(at, scan_data_);
      describe(at, drive);
    }
    if (auto moved = chassis_->move(drive.speed, drive.side, drive.omega); !moved) return moved;
    return put_local_buffer();
  }

  void describe(const Pose& at, const Drive& drive) {
    PilotData& data = get_local_buffer();
    data.recordingTime = scan_data_.recordingTime;
    data.pos = at.position();
    data.dest = course_->destination().pos;
    data.speed = drive.speed;
    data.curve = drive.speed == 0 ? 0 : drive.omega / static_cast<f32>(drive.speed);
    data.distanceToDest = whole_millimetres(course_->distance(at));
    data.pilotState =
        course_->state() == LabCourse::State::kIdle ? pilot_state::kIdle : pilot_state::kRunning;
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != PilotType::kSetDestination)
      return DataModule::module_command(message);
    const auto command = decode<PilotDestData>(message);
    if (!command) return command.error();
    if (!is_on()) return refused("the pilot is off; turn it on first");
    {
      const std::lock_guard lock(course_mutex_);
      course_->set_destination(*command);
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  OwnMailbox work_{*this, 10, wire_size<ChassisParamData>()};
  Partner<ChassisProxy> chassis_{*this, "chassis", work_};
  Partner<PositionProxy> position_{*this, "position", work_};
  Input<Scan2dProxy> scan_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  Scan2dData scan_data_;
  PriorityMutex course_mutex_;  // protects the members below
  std::optional<LabCourse> course_;
};

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  rack::pilot::PilotLab pilot;
  return pilot.run(argc, argv);
}

// A ladar on the axis ServoDrive(0/0), on the robot at Position(0/0), in the hall of
// hall_fixture.h; only for tests. It measures with a delay, from the positions of axis and robot at
// the time of each point.
#include <array>

#include "components/scan3d/hall_fixture.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"
#include "rack/proxies/position.h"
#include "rack/proxies/servo_drive.h"

namespace rack::scan3d {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = std::chrono::microseconds(13333);
constexpr auto kLate = 250ms;  // by then the positions of axis and robot are known

constexpr std::array<ParameterInfo, 2> kParameters = {{
    partner("servoDrive", "the drive of the axis"),
    partner("position", "the position"),
}};

constexpr ModuleInfo kInfo{.program = "tims-test-ladar",
                           .purpose = "A ladar on an axis, in a hall.",
                           .class_id = tims::class_id::kLadar,
                           .parameters = kParameters};

class TiltedLadar : public DataModule<LadarData> {
 public:
  TiltedLadar() : DataModule(kInfo, {.history = 10}) {
    ride_.mounting = {
        .mode = scan_mode::kPitch, .axis = {.x = 300, .z = -400}, .is_reversed = true};
    ride_.noise = 6;
  }

 private:
  Result<void> module_on() override {
    set_period(13ms);
    if (auto on = servo_.turn_on(); !on) return on;
    if (auto on = position_.turn_on(); !on) return on;
    return DataModule::module_on();
  }
  Result<void> module_loop() override {
    sleep_until_next(kPeriod);
    const auto axis = servo_->get_data();
    if (!axis) return axis.error();
    const auto position = position_->get_data();
    if (!position) return position.error();
    axis_.add(axis->recordingTime, static_cast<double>(axis->position));
    poses_.add(position->recordingTime, Pose::of(position->pos));
    const TimeStamp middle = time_stamp() - kLate;
    if (!axis_.at(middle, -10) || !axis_.at(middle, 10)) return {};
    if (!poses_.at(middle, -10) || !poses_.at(middle, 10)) return {};
    ride_.axis = [&](double s) { return *axis_.at(middle, 1000 * s); };
    ride_.robot = [&](double s) { return *poses_.at(middle, 1000 * s); };
    LadarData& scan = get_local_buffer();
    scan = flat_scan(ride_, hall_, 0);
    scan.recordingTime = middle;
    return put_local_buffer();
  }

  OwnMailbox work_{*this, 1, 256};
  Partner<ServoDriveProxy> servo_{*this, "servoDrive", work_};
  Partner<PositionProxy> position_{*this, "position", work_};
  Trajectory<double> axis_;
  Trajectory<Pose> poses_;
  Ride ride_;
  const std::vector<Plane> hall_ = hall(200'000);
};

}  // namespace
}  // namespace rack::scan3d

int main(int argc, char** argv) {
  rack::scan3d::TiltedLadar ladar;
  return ladar.run(argc, argv);
}

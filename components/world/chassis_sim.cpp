// ChassisSim: a simulated chassis.
#include <algorithm>
#include <array>
#include <mutex>

#include "components/devices/chassis/move_deadline.h"
#include "components/world/core/models.h"
#include "rack/chassis_module.h"
#include "rack/clock.h"

namespace rack::sim {
namespace {

constexpr auto kParameters = joined(
    chassis_limits({.omegaMax = 20}),
    std::array<ParameterInfo, 5>{{
        {"vyMax", 0, "maximum speed to the side [mm/s]", 0, 1e6},
        {"vyMin", 0, "minimum speed to the side other than 0 [mm/s]", 0, 1e6},
        {"periodTime", 100, "period of the data [ms]", 1, 60000},
        {"acceleration", 0, "1: limit the change of speeds by accMax and decMax", 0, 1},
        {"moveDeadline", -1,
         "validity of a MOVE [ms]; -1: three periods of the pilot, 0: without end, as the original",
         -1, 10000},
    }});

constexpr ModuleInfo kInfo{
    .program = "ChassisSim",
    .purpose = "A simulated chassis: follows commands within its limits.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

class ChassisSim : public ChassisModule<DataModule<ChassisData>, ChassisModel> {
 public:
  // Each data set contains a movement, so none may be skipped: no samples.
  ChassisSim() : ChassisModule(kInfo, {.history = 5, .samples = false}) {}

 private:
  Result<void> module_on() override {
    {
      const std::lock_guard lock(control_mutex_);
      control_.emplace(limits(), integer("acceleration") != 0);
      const int valid = integer("moveDeadline");
      has_deadline_ = valid != 0;
      deadline_ = device::MoveDeadline(std::chrono::milliseconds(std::max(valid, 0)));
    }
    set_period(std::chrono::milliseconds(integer("periodTime")));
    return DataModule::module_on();
  }

  void module_off() override {
    const std::lock_guard lock(control_mutex_);
    control_.reset();
  }

  Result<void> module_loop() override {
    sleep_until_next(period());
    bool is_overdue = false;
    {
      const std::lock_guard lock(control_mutex_);
      is_overdue = has_deadline_ && deadline_.due() <= now();
      if (is_overdue) stop();
      get_local_buffer() = control_->step(time_stamp(), period());
    }
    if (is_overdue)
      log().warning("No MOVE from {} in time, stopped",
                    tims::Address(get_local_buffer().activePilot));
    return put_local_buffer();
  }

  void stop() {
    control_->move({});
    deadline_.end();
  }

  // A vehicle at rest needs no further command, as with the drivers.
  void steer(const ChassisMoveData& command) override {
    control_->move(command);
    deadline_.on_move(now());
    if (command.vx == 0 && command.vy == 0 && command.omega == 0) deadline_.end();
  }
  void pilot_was_set() override { deadline_.forget(); }

  [[nodiscard]] ChassisParamData limits() const override {
    ChassisParamData limits = ChassisModule::limits();
    limits.vyMax = integer("vyMax");
    limits.vyMin = integer("vyMin");
    return limits;
  }

  // Both under the lock.
  device::MoveDeadline deadline_;
  bool has_deadline_ = true;
};

}  // namespace
}  // namespace rack::sim

int main(int argc, char** argv) {
  rack::sim::ChassisSim chassis;
  return chassis.run(argc, argv);
}

// ChassisSim: a simulated chassis.
#include <array>
#include <mutex>

#include "components/world/core/models.h"
#include "rack/chassis_module.h"
#include "rack/clock.h"

namespace rack::sim {
namespace {

constexpr auto kParameters =
    joined(chassis_limits({.omegaMax = 20}),
           std::array<ParameterInfo, 4>{{
               {"vyMax", 0, "maximum speed to the side, mm/s", 0, 1e6},
               {"vyMin", 0, "minimum speed to the side other than 0, mm/s", 0, 1e6},
               {"periodTime", 100, "period of the data, ms", 1, 60000},
               {"acceleration", 0, "1: limit the change of speeds by accMax and decMax", 0, 1},
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
    {
      const std::lock_guard lock(control_mutex_);
      get_local_buffer() = control_->step(time_stamp(), period());
    }
    return put_local_buffer();
  }

  void steer(const ChassisMoveData& command) override { control_->move(command); }

  [[nodiscard]] ChassisParamData limits() const override {
    ChassisParamData limits = ChassisModule::limits();
    limits.vyMax = integer("vyMax");
    limits.vyMin = integer("vyMin");
    return limits;
  }
};

}  // namespace
}  // namespace rack::sim

int main(int argc, char** argv) {
  rack::sim::ChassisSim chassis;
  return chassis.run(argc, argv);
}

// ChassisSim: a chassis without wheels.
#include <array>
#include <mutex>
#include <optional>

#include "components/geometry/pose.h"
#include "components/sim/models.h"
#include "rack/clock.h"
#include "rack/data_module.h"

namespace rack::sim {
namespace {

constexpr double kMax = 1e6;

constexpr std::array<ParameterInfo, 24> kParameters = {{
    {"vxMax", 700, "largest speed, mm/s", 0, kMax},
    {"vxMin", 50, "smallest speed that is not 0, mm/s", 0, kMax},
    {"vyMax", 0, "largest speed to the side, mm/s", 0, kMax},
    {"vyMin", 0, "smallest one that is not 0, mm/s", 0, kMax},
    {"accMax", 500, "acceleration, mm/s2", 0, kMax},
    {"decMax", 500, "deceleration, mm/s2", 0, kMax},
    {"omegaMax", 20, "largest turning speed, deg/s", 0, 3600},
    {"minTurningRadius", 200, "mm", 0, kMax},
    {"breakConstant", 100, "way for braking, mm for each 100 mm/s", 0, kMax},
    {"safetyMargin", 50, "around the hull, mm", 0, kMax},
    {"safetyMarginMove", 200, "more of it where it goes, mm", 0, kMax},
    {"comfortMargin", 300, "mm", 0, kMax},
    {"front", 250, "hull before the reference point, mm", 0, kMax},
    {"back", 250, "hull behind it, mm", 0, kMax},
    {"left", 250, "hull left of it, mm", 0, kMax},
    {"right", 250, "hull right of it, mm", 0, kMax},
    {"wheelBase", 280, "mm", 0, kMax},
    {"wheelRadius", 110, "mm", 0, kMax},
    {"trackWidth", 280, "mm", 0, kMax},
    {"pilotParameterA", 10, "gain for the distance to the path, 1/10000 rad/mm", 0, kMax},
    {"pilotParameterB", 200, "gain for the heading, 1/100 1/s", 0, kMax},
    {"pilotVTransMax", 200, "mm/s", 0, kMax},
    {"periodTime", 100, "of the data, ms", 1, 60000},
    {"acceleration", 0, "1: speeds change no faster than accMax and decMax allow", 0, 1},
}};

constexpr ModuleInfo kInfo{
    .program = "ChassisSim",
    .purpose = "A simulated chassis: does as it is told, within its limits.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

class ChassisSim : public DataModule<ChassisData> {
 public:
  // A movement that is left out is lost: no samples.
  ChassisSim() : DataModule(kInfo, {.history = 5, .samples = false}) {}

 private:
  Result<void> module_on() override {
    {
      const std::lock_guard lock(model_mutex_);
      model_.emplace(limits(), integer("acceleration") != 0);
    }
    set_period(std::chrono::milliseconds(integer("periodTime")));
    return DataModule::module_on();
  }

  void module_off() override {
    const std::lock_guard lock(model_mutex_);
    model_.reset();
  }

  Result<void> module_loop() override {
    sleep_until_next(period());
    {
      const std::lock_guard lock(model_mutex_);
      get_local_buffer() = model_->step(time_stamp(), period());
    }
    return put_local_buffer();
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case ChassisType::kMove:
        return move(message);
      case ChassisType::kGetParameter:
        reply(message.header, ChassisType::kParameter, limits_in_force());
        return {};
      case ChassisType::kSetActivePilot:
        return set_active_pilot(message);
      default:
        return DataModule::module_command(message);
    }
  }

  Result<void> move(const tims::MessageView& message) {
    const auto wish = decode<ChassisMoveData>(message);
    if (!wish) return wish.error();
    {
      const std::lock_guard lock(model_mutex_);
      if (!model_) return refused("the chassis is off");
      if (component_of(message.header.src) != model_->active_pilot())
        return refused(not_active(component_of(message.header.src)));
      model_->move(*wish);
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  // With the lock of the model.
  [[nodiscard]] std::string not_active(tims::Address pilot) const {
    const tims::Address active = model_->active_pilot();
    const auto widths = address_widths();
    return pilot.to_string(widths) + " is not its active pilot, " +
           (active == kNoPilot ? "it has none" : "that is " + active.to_string(widths));
  }

  Result<void> set_active_pilot(const tims::MessageView& message) {
    const auto wish = decode<ChassisSetActivePilotData>(message);
    if (!wish) return wish.error();
    const bool none = wish->activePilot == kNoPilot;
    const tims::Address pilot = none ? kNoPilot : component_of(wish->activePilot);
    bool is_new = false;
    {
      const std::lock_guard lock(model_mutex_);
      is_new = model_ && model_->active_pilot() != pilot;
      if (model_) model_->set_active_pilot(pilot);
    }
    if (is_new && none) log().print("No active pilot, says %n", message.header.src);
    if (is_new && !none) log().print("Active pilot is %n, says %n", pilot, message.header.src);
    reply(message.header, tims::type::kOk);
    return {};
  }

  // Parameters are read at every ON; while it is off, those of the next one.
  [[nodiscard]] ChassisParamData limits_in_force() {
    {
      const std::lock_guard lock(model_mutex_);
      if (model_) return model_->limits();
    }
    return limits();
  }

  [[nodiscard]] ChassisParamData limits() const {
    ChassisParamData limits;
    limits.vxMax = integer("vxMax");
    limits.vyMax = integer("vyMax");
    limits.vxMin = integer("vxMin");
    limits.vyMin = integer("vyMin");
    limits.accMax = integer("accMax");
    limits.decMax = integer("decMax");
    limits.omegaMax = static_cast<float>(radians(integer("omegaMax")));
    limits.minTurningRadius = integer("minTurningRadius");
    limits.breakConstant = static_cast<float>(integer("breakConstant")) / 100;
    limits.safetyMargin = integer("safetyMargin");
    limits.safetyMarginMove = integer("safetyMarginMove");
    limits.comfortMargin = integer("comfortMargin");
    limits.boundaryFront = integer("front");
    limits.boundaryBack = integer("back");
    limits.boundaryLeft = integer("left");
    limits.boundaryRight = integer("right");
    limits.wheelBase = integer("wheelBase");
    limits.wheelRadius = integer("wheelRadius");
    limits.trackWidth = integer("trackWidth");
    limits.pilotParameterA = static_cast<float>(integer("pilotParameterA")) / 10000;
    limits.pilotParameterB = static_cast<float>(integer("pilotParameterB")) / 100;
    limits.pilotVTransMax = integer("pilotVTransMax");
    return limits;
  }

  PriorityMutex model_mutex_;
  std::optional<ChassisModel> model_;  // while it is on
};

}  // namespace
}  // namespace rack::sim

int main(int argc, char** argv) {
  rack::sim::ChassisSim chassis;
  return chassis.run(argc, argv);
}

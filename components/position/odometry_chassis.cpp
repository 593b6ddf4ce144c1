// OdometryChassis: integrates the movements of a chassis.
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "components/geometry/pose.h"
#include "components/position/reckoning.h"
#include "rack/data_module.h"
#include "rack/input.h"

namespace rack::navigation {
namespace {

constexpr std::array<ParameterInfo, 4> kParameters = {{
    partner("chassis", "the chassis"),
    {"initPosX", 0, "initial x [mm]"},
    {"initPosY", 0, "initial y [mm]"},
    {"initPosRho", 0, "initial heading [deg]"},
}};

constexpr ModuleInfo kInfo{
    .program = "OdometryChassis",
    .purpose = "Odometry: integrates the movements that a chassis reports.",
    .class_id = tims::class_id::kOdometry,
    .parameters = kParameters,
};

class OdometryChassis : public DataModule<OdometryData> {
 public:
  OdometryChassis() : DataModule(kInfo, {.history = 1000}) {}

 private:
  Result<void> module_on() override {
    {
      const std::lock_guard lock(reckoning_mutex_);
      if (!failed_ || !reckoning_) reckoning_.emplace(start());
    }
    const auto granted = chassis_.start();
    if (!granted) return granted.error();
    set_period(*granted);
    ahead_ = *granted;
    return DataModule::module_on();
  }

  void module_off() override { chassis_.stop(); }

  Result<void> module_loop() override {
    auto come = chassis_.next(movement_, patience_with(period()));
    failed_ = !come;
    if (failed_) return come;
    {
      const std::lock_guard lock(reckoning_mutex_);
      get_local_buffer() = reckoning_->add(movement_);
    }
    report_pose(get_local_buffer().pos);
    return put_local_buffer();
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != OdometryType::kReset) return DataModule::module_command(message);
    {
      const std::lock_guard lock(reckoning_mutex_);
      if (reckoning_) reckoning_->reset();
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  Result<std::size_t> data_at(TimeStamp time, std::span<std::byte> to) const override {
    return data_between(time, ahead_.load(), to, interpolated);
  }

  // Reports the pose to the supervisor: a program that is restarted after a crash continues there,
  // exact to the millimetre and degree.
  void report_pose(const Position3d& pos) {
    const auto degree = std::lround(degrees(pos.rho.raw()));
    const auto report = [this](std::string_view name, std::int64_t& reported, std::int64_t now) {
      if (std::exchange(reported, now) != now) report_state(name, std::to_string(now));
    };
    report("initPosX", reported_[0], pos.x.raw());
    report("initPosY", reported_[1], pos.y.raw());
    report("initPosRho", reported_[2], degree);
  }

  [[nodiscard]] Pose start() const {
    return {.x = static_cast<double>(integer("initPosX")),
            .y = static_cast<double>(integer("initPosY")),
            .rho = heading(radians(integer("initPosRho")))};
  }

  OwnMailbox work_{*this, 1, 128};
  Input<ChassisProxy> chassis_{*this, "chassis", work_, DeadReckoning::kDataWaiting,
                               wire_size<ChassisData>()};
  ChassisData movement_;
  bool failed_ = false;  // after an error it continues at its pose; after OFF it starts again
  std::array<std::int64_t, 3> reported_{};          // x, y, heading
  std::atomic<std::chrono::milliseconds> ahead_{};  // maximum extrapolation beyond the newest data
  PriorityMutex reckoning_mutex_;
  std::optional<DeadReckoning> reckoning_;
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::OdometryChassis odometry;
  return odometry.run(argc, argv);
}

// OdometryChassis: adds up what a chassis says it has moved.
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

constexpr std::array<ParameterInfo, 5> kParameters = {{
    {"chassisSys", 0, "system id of the chassis", 0, kIdMax},
    {"chassisInst", 0, "instance of the chassis", 0, kIdMax},
    {"initPosX", 0, "where it is when it is turned on, mm"},
    {"initPosY", 0, "mm"},
    {"initPosRho", 0, "deg"},
}};

constexpr ModuleInfo kInfo{
    .program = "OdometryChassis",
    .purpose = "Odometry: adds up what a chassis says it has moved.",
    .class_id = tims::class_id::kOdometry,
    .parameters = kParameters,
};

class OdometryChassis : public DataModule<OdometryData> {
 public:
  OdometryChassis() : DataModule(kInfo, {.history = 1000}) {}

 private:
  Result<void> module_init() override {
    const auto work = create_mailbox(1, 128);
    if (!work) return work.error();
    return create_input(chassis_, **work, 4, wire_size<ChassisData>());
  }

  Result<void> module_on() override {
    {
      const std::lock_guard lock(reckoning_mutex_);
      if (!failed_ || !reckoning_) reckoning_.emplace(start());
    }
    const auto granted = chassis_->start(address_of(tims::class_id::kChassis, "chassis"));
    if (!granted) return granted.error();
    set_period(*granted);
    ahead_ = *granted;
    return DataModule::module_on();
  }

  void module_off() override { chassis_->stop(); }

  Result<void> module_loop() override {
    auto come = chassis_->next(movement_, 2 * period());
    failed_ = !come;
    if (failed_) return come;
    {
      const std::lock_guard lock(reckoning_mutex_);
      get_local_buffer() = reckoning_->add(movement_);
    }
    tell_place(get_local_buffer().pos);
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

  // A program that is started again after a crash goes on where it was, to the millimetre and
  // degree.
  void tell_place(const Position3d& pos) {
    const auto degree = std::lround(degrees(pos.rho.raw()));
    const auto tell = [this](std::string_view name, std::int64_t& told, std::int64_t now) {
      if (std::exchange(told, now) != now) tell_state(name, std::to_string(now));
    };
    tell("initPosX", told_[0], pos.x.raw());
    tell("initPosY", told_[1], pos.y.raw());
    tell("initPosRho", told_[2], degree);
  }

  [[nodiscard]] Pose start() const {
    return {.x = static_cast<double>(integer("initPosX")),
            .y = static_cast<double>(integer("initPosY")),
            .rho = heading(radians(integer("initPosRho")))};
  }

  std::optional<Input<ChassisProxy>> chassis_;
  ChassisData movement_;
  bool failed_ = false;                 // goes on where it was; after OFF it begins anew
  std::array<std::int64_t, 3> told_{};  // x, y, heading
  std::atomic<std::chrono::milliseconds> ahead_{};  // how far beyond the newest data it guesses
  PriorityMutex reckoning_mutex_;
  std::optional<DeadReckoning> reckoning_;
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::OdometryChassis odometry;
  return odometry.run(argc, argv);
}

// Emulator of an ER1 control module: two motion processors, which keep turning until a stop
// command.
#pragma once

#include "components/devices/chassis/er1.h"
#include "components/devices/chassis/wheeled_model.h"

namespace rack::device {

class Er1Emulator final : public WheeledRobot {
 public:
  static constexpr double kTicksOfMillimetre = 20;

  Er1Emulator() : WheeledRobot(WheeledModel{380, 1500}) {}

  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output& out) override;

  [[nodiscard]] bool is_powered() const { return power_[0] > 0 && power_[1] > 0; }

 private:
  void on_command(std::span<const std::byte> bytes, Output& out);

  StreamBuffer received_{128};
  std::array<std::int32_t, 2> velocity_{};  // takes effect with Update
  std::array<std::int32_t, 2> in_force_{};
  std::array<std::int32_t, 2> power_{};
};

}  // namespace rack::device

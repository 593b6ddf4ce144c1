// A compass CMPS03 behind its board, which turns by some degrees a second.
#pragma once

#include "devices/core/dialogue.h"

namespace rack::device::emulator {

class Cmps03Emulator final : public Dialogue {
 public:
  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  // Directions that were calibrated, each confirmed.
  [[nodiscard]] int directions() const { return directions_; }

 private:
  static constexpr Duration kPeriod = std::chrono::milliseconds(100);
  static constexpr double kTurn = 15;  // deg/s

  bool is_confirming_ = false;  // it has said OK
  int directions_ = 0;
  Time began_{};
  Time next_ = tims::kNever;
};

}  // namespace rack::device::emulator

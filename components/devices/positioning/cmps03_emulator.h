// Emulator of a CMPS03 compass with its board. It turns slowly, or follows its scene.
#pragma once

#include <cmath>
#include <utility>

#include "components/devices/core/scene.h"

namespace rack::device::emulator {

// The default scene; deg/s, clockwise.
struct SlowTurn {
  double speed = 15;
  double operator()(Time /*when*/, Duration since_start) const {
    return std::fmod(speed * std::chrono::duration<double>(since_start).count(), 360);
  }
};

class Cmps03Emulator final : public Dialogue {
 public:
  explicit Cmps03Emulator(Heading heading = SlowTurn{}) : heading_(std::move(heading)) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  // Number of calibrated and confirmed directions.
  [[nodiscard]] int directions() const { return directions_; }

 private:
  static constexpr Duration kPeriod = std::chrono::milliseconds(100);

  Heading heading_;
  bool is_confirming_ = false;  // has sent OK
  int directions_ = 0;
  Time began_{};
  Time next_ = tims::kNever;
};

}  // namespace rack::device::emulator

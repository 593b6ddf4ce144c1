// Emulator of an LD06 or LD19: sends measurements of a room from the start.
#pragma once

#include <vector>

#include "components/devices/scanners/ld19.h"
#include "components/devices/scanners/room.h"

namespace rack::device::emulator {

struct Ld19Settings {
  int points_a_second = 4500;
  int turns_a_second = 10;
  Sight sight = Room{};
};

class Ld19 final : public Dialogue {
 public:
  explicit Ld19(const Ld19Settings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

 private:
  [[nodiscard]] double angle_of(std::uint64_t point) const;  // degrees, over many turns
  [[nodiscard]] Duration packet_time() const;

  Ld19Settings settings_;
  Time began_{};
  Time next_ = tims::kNever;
  std::uint64_t point_ = 0;
  std::vector<std::byte> packet_;
};

}  // namespace rack::device::emulator

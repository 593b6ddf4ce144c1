// Emulator of an Ibeo LD-A: spins up, measures a room in two sectors, and sends CAN frames.
#pragma once

#include <vector>

#include "components/devices/scanners/ibeo.h"
#include "components/devices/scanners/room.h"

namespace rack::device::emulator {

struct IbeoSettings {
  std::uint8_t sensor = 1;
  Duration spin_up = std::chrono::seconds(3);
  unsigned measure_error = 0;
  bool is_broken = false;
  Sight sight = Room{};
};

class Ibeo final : public Dialogue {
 public:
  explicit Ibeo(const IbeoSettings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] unsigned mode() const { return mode_; }
  [[nodiscard]] bool sends() const { return next_ != tims::kNever; }

 private:
  void obey(const IbeoTelegram& telegram, Time now, Output& out);
  void answer(std::uint16_t service, Output& out);
  void append(unsigned number);
  void append_status(Time now);
  void append_sector(int from, int to, Time begin);
  [[nodiscard]] unsigned counter(Time time) const;

  IbeoSettings settings_;
  IbeoTelegrams telegrams_{1};
  unsigned mode_ = ibeo::kModeIdle;
  Time measures_since_{};
  Time zero_{};  // zero of the scanner's clock
  Time next_ = tims::kNever;
  unsigned format_ = 0;
  std::vector<std::byte> data_;
  std::vector<IbeoFrame> frames_;
};

}  // namespace rack::device::emulator

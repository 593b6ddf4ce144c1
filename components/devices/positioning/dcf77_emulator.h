// Emulators of DCF77 radio clocks: a telegram each second, synchronised a few seconds after
// power-on.
#pragma once

#include <string>

#include "components/devices/positioning/dcf77.h"

namespace rack::device::emulator {

struct Dcf77EmulatorSettings {
  Dcf77Kind kind = Dcf77Kind::kMeinberg;
  std::chrono::seconds begins = std::chrono::hours(24) * 20454;  // UTC, 2026-01-01
  std::chrono::seconds synchronised_after{3};
};

// The telegram of a second, in the local time of central Europe.
std::string dcf77_telegram(Dcf77Kind kind, std::chrono::seconds utc, bool is_synchronised);

class Dcf77Emulator : public Dialogue {
 public:
  Dcf77Emulator() : Dcf77Emulator(Dcf77EmulatorSettings{}) {}
  explicit Dcf77Emulator(const Dcf77EmulatorSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

 private:
  Dcf77EmulatorSettings settings_;
  std::chrono::seconds passed_{};
  Time next_ = tims::kNever;
};

class EmcProEmulator final : public Dcf77Emulator {
 public:
  EmcProEmulator() : Dcf77Emulator({.kind = Dcf77Kind::kEmcPro}) {}
};

}  // namespace rack::device::emulator

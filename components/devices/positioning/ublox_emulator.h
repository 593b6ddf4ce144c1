// Emulator of a u-blox receiver: sends NMEA at first, NAV-PVT after configuration. Up to the eighth
// generation it refuses CFG-VALSET and accepts CFG-PRT, CFG-RATE and CFG-MSG instead.
#pragma once

#include "components/devices/positioning/gps_course.h"
#include "components/devices/positioning/ubx.h"

namespace rack::device::emulator {

struct UbloxEmulatorSettings {
  int generation = 9;
  std::uint32_t baud = 38400;
  Course course = GpsCourse{};
};

void append_pvt(std::vector<std::byte>& out, const CoursePoint& point);

class UbloxEmulator : public Dialogue {
 public:
  UbloxEmulator() : UbloxEmulator(UbloxEmulatorSettings{}) {}
  explicit UbloxEmulator(const UbloxEmulatorSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] Duration period() const { return period_; }
  [[nodiscard]] bool sends_pvt() const { return sends_pvt_; }

 private:
  void on_frame(const UbxFrame& frame, Output& out);
  bool set_values(std::span<const std::byte> payload);
  bool set_value(std::uint32_t key, std::uint64_t value);
  bool set_old(const UbxFrame& frame);

  UbloxEmulatorSettings settings_;
  UbxStream stream_;
  Time began_{};
  Time next_ = tims::kNever;
  Duration period_ = std::chrono::seconds(1);
  bool sends_pvt_ = false;
  std::uint32_t baud_ = 0;
  std::uint32_t next_baud_ = 0;  // rate after the answer
  std::vector<std::byte> burst_;
};

}  // namespace rack::device::emulator

// Emulator of a satellite receiver that sends RMC, VTG, GGA, GSA, GST and ZDA without requests.
#pragma once

#include <string>
#include <vector>

#include "components/devices/positioning/gps_course.h"

namespace rack::device::emulator {

struct NmeaEmulatorSettings {
  Course course = GpsCourse{};
  Duration period = std::chrono::seconds(1);
  Duration delay = std::chrono::milliseconds(80);  // from the fix to the first byte
  std::string talker = "GN";
};

// Appends the sentences of one fix, with their line ends.
void append_sentences(std::vector<std::byte>& out, const CoursePoint& point,
                      const std::string& talker);

class NmeaEmulator final : public Dialogue {
 public:
  NmeaEmulator() : NmeaEmulator(NmeaEmulatorSettings{}) {}
  explicit NmeaEmulator(NmeaEmulatorSettings settings) : settings_(std::move(settings)) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return fix_ + settings_.delay; }

 private:
  NmeaEmulatorSettings settings_;
  Time began_{};
  Time fix_ = tims::kNever - std::chrono::hours(1);
  std::vector<std::byte> burst_;
};

}  // namespace rack::device::emulator

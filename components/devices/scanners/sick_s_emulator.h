// Emulator of a SICK S300 or S3000: sends scans of its scene every 40 or 30 ms, or less often if
// the line is slower, and receives nothing.
#pragma once

#include "components/devices/scanners/room.h"
#include "components/devices/scanners/sick_s.h"

namespace rack::device::emulator {

struct SickSEmulatorSettings {
  SickSDevice device = SickSDevice::kS300;
  bool is_slave = false;
  std::uint32_t baud = 500000;
  bool sends_inputs = false;  // sends blocks of inputs and outputs between scans
  Sight sight = Room{};
};

class SickSEmulator final : public Dialogue {
 public:
  explicit SickSEmulator(const SickSEmulatorSettings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& /*arrival*/, Output& /*out*/) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return scan_at_; }

  [[nodiscard]] std::uint32_t scans_sent() const { return scans_sent_; }

 private:
  void send(std::span<const std::byte> blocks, Output& out);

  SickSEmulatorSettings settings_;
  std::vector<std::byte> blocks_;
  std::vector<std::byte> telegram_;
  std::uint32_t scans_sent_ = 0;
  Time scan_at_ = tims::kNever;
};

// Appends a block of distances, measured until `end`.
void append_sick_s_scan(std::vector<std::byte>& blocks, SickSDevice device, const Sight& sight,
                        Time end);

}  // namespace rack::device::emulator

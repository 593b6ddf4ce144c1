// Emulator of a SICK picoScan or multiScan: sends turns of its scene in segments, one per datagram,
// and receives nothing.
#pragma once

#include "components/devices/scanners/room.h"
#include "components/devices/scanners/sick_compact.h"

namespace rack::device::emulator {

struct SickCompactEmulatorSettings {
  std::uint32_t version = 4;
  std::uint32_t serial_number = 23110001;
  Duration turn = std::chrono::milliseconds(50);
  int segments = 12;    // per turn
  int beams = 276;      // per segment and layer
  double first = -138;  // degrees, counterclockwise
  double last = 138;
  std::vector<float> elevations = {0};  // elevations of the layers, rad
  int echoes = 1;
  float factor = 1;  // factor of distances
  Sight sight = Room{};
};

// Appends segment `number` of turn `frame`, which began at `started`, us; sent at `transmitted`,
// us.
void append_compact(std::vector<std::byte>& out, const SickCompactEmulatorSettings& settings,
                    std::uint64_t frame, int number, std::uint64_t started,
                    std::uint64_t transmitted);

class SickCompactEmulator final : public Dialogue {
 public:
  explicit SickCompactEmulator(SickCompactEmulatorSettings settings = {})
      : settings_(std::move(settings)) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& /*arrival*/, Output& /*out*/) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] std::uint64_t turns_sent() const { return frame_; }

 private:
  [[nodiscard]] Duration segment_time() const;

  SickCompactEmulatorSettings settings_;
  std::vector<std::byte> datagram_;
  std::uint64_t frame_ = 0;
  int segment_ = 0;
  Time turn_began_{};
  Time next_ = tims::kNever;  // when the next segment is complete and sent
};

}  // namespace rack::device::emulator

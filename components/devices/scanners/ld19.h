// LDROBOT LD06, LD19 and STL-19P: rotating range finders that send without requests.
//
// After power-on they send packets of 47 bytes at 230400 baud: 54 2C, speed in degrees per second,
// the angle of the first of twelve points in 1/100 degree, their distances in mm and intensities,
// the angle of the last point, a time that wraps after 30000 ms, and a CRC. All little-endian;
// angles are clockwise.
//
// Source: "LD19 Development Manual", "LD06 Development Manual" (the example there is the test's).
#pragma once

#include "components/devices/scanners/turning_ladar.h"
#include "rack/devices/device_clock.h"
#include "rack/devices/stream_buffer.h"

namespace rack::device {

// CRC-8 with polynomial 4D.
std::uint8_t ld19_crc(std::span<const std::byte> bytes);

inline constexpr std::size_t kLd19Points = 12;
inline constexpr std::size_t kLd19Size = 47;

struct Ld19Settings {
  std::uint32_t baud = 230400;
  bool only_listen = false;  // the device is a recording
};

class Ld19 final : public TurningLadar {
 public:
  explicit Ld19(const Ld19Settings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] std::uint64_t packets() const { return packets_; }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  void decode(std::span<const std::byte> packet, Time came);

  static constexpr std::size_t kLongest = 1 << 16;
  static constexpr std::uint64_t kTimeEnd = 30'000;

  Ld19Settings settings_;
  StreamBuffer buffer_{kLongest};
  DeviceClock clock_{std::chrono::milliseconds(1), kTimeEnd};
  std::uint64_t packets_ = 0;
  std::uint64_t broken_ = 0;
};

}  // namespace rack::device

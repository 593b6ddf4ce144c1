// Emulator of an RPLIDAR: identity, health, modes, and measurements of its scene in any of the four
// kinds of packets.
#pragma once

#include <vector>

#include "components/devices/scanners/room.h"
#include "components/devices/scanners/rplidar_packets.h"

namespace rack::device::emulator {

struct RplidarSettings {
  std::uint32_t baud = 115200;
  std::uint8_t model = 0x18;            // A1
  std::uint16_t firmware = 0x011D;      // 1.29
  std::uint8_t type = rplidar::kPairs;  // packet type of the typical mode
  int points_a_second = 4000;
  int turns_a_minute = 600;
  bool is_broken = false;  // until it is reset
  bool stays_broken = false;
  Duration spin_up = std::chrono::milliseconds(500);
  double range = 12;               // m
  std::uint8_t serial_number = 6;  // last byte of the serial number
  Sight sight = Room{};
};

class Rplidar final : public Dialogue {
 public:
  explicit Rplidar(const RplidarSettings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] bool measures() const { return type_ != 0; }
  [[nodiscard]] unsigned motor() const { return motor_; }

 private:
  // Executes the first command in waiting_. Returns its size; 0: it is incomplete.
  std::size_t take_command(Time now, Output& out);
  void obey(std::uint8_t command, std::span<const std::byte> payload, Time now, Output& out);
  void answer(std::uint8_t type, std::span<const std::byte> data, Output& out);
  void answer_configuration(std::span<const std::byte> payload, Output& out);
  void begin(std::uint8_t type, Time now, Output& out);
  void append_point();
  void append_pairs();
  void append_triples();
  void append_dense();
  void append_head();
  [[nodiscard]] double angle_of(std::uint64_t point) const;  // degrees, over many turns
  // Distance at `degrees`, close to the direction of `point`.
  [[nodiscard]] std::int32_t seen(double degrees, std::uint64_t point) const;
  [[nodiscard]] Duration packet_time() const;

  RplidarSettings settings_;
  bool is_broken_ = false;
  std::uint8_t type_ = 0;
  std::uint64_t point_ = 0;  // number of points measured so far
  unsigned motor_ = 0;
  Time next_ = tims::kNever;
  std::vector<std::byte> waiting_;
  std::vector<std::byte> packet_;
};

}  // namespace rack::device::emulator

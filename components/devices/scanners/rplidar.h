// Setup and measurement of the Slamtec RPLIDAR A, S and C series. See rplidar_packets.h for the
// protocol.
//
// The dialogue detects the baud rate, stops the scanner, reads its identity and health (and resets
// it after an error), starts the motor by DTR or by a command, and requests the best measurement
// mode of the scanner.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "components/devices/scanners/rplidar_packets.h"

namespace rack::device {

struct RplidarSettings {
  std::uint32_t baud = 115200;  // 115200 A1 A2, 256000 A3 S1, 460800 C1, 1000000 S2 S3
  bool has_rate = true;         // the line is a serial line
  bool only_points = false;     // use single points (81), supported by all
  int turns_a_minute = 0;       // if the speed is adjustable; 0: default of the scanner
  std::string serial_number{};  // required serial number, 32 hex digits; empty: any
  bool only_listen = false;     // the device is a recording
};

struct RplidarInfo {
  std::uint8_t model = 0;  // 18 A1, 28 A2, 31 A3, 41 C1, 61 S1, 71 S2, 81 S3
  std::uint16_t firmware = 0;
  std::uint8_t hardware = 0;
  std::string serial_number{};
};

class Rplidar final : public TurningLadar {
 public:
  explicit Rplidar(const RplidarSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;

  [[nodiscard]] std::string serial_number() const override { return info_.serial_number; }
  [[nodiscard]] const RplidarInfo& info() const { return info_; }
  [[nodiscard]] std::uint8_t type() const { return type_; }
  [[nodiscard]] std::uint64_t lost() const { return packets_.lost(); }

 private:
  // In the order of the setup.
  enum class State : std::uint8_t {
    kStop,
    kInfo,
    kHealth,
    kReset,
    kMode,
    kType,
    kRange,
    kScan,
    kMeasuring,
  };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void ask_configuration(std::uint32_t entry, bool with_mode);
  void retry(Time now, Output& out);
  void try_next_rate(Time now, Output& out);
  void take_packet(const RplidarPacket& packet, Time now, Output& out);
  void take_configuration(const RplidarPacket& packet, Time now, Output& out);
  void on_info(const RplidarPacket& packet, Time now, Output& out);
  void on_health(const RplidarPacket& packet, Time now, Output& out);
  void turn_motor_on(Output& out);
  [[nodiscard]] bool has_motor_command() const;
  void send(std::uint8_t command, std::span<const std::byte> payload, Output& out);

  RplidarSettings settings_;
  State state_ = State::kStop;
  std::size_t rate_index_ = 0;
  std::uint32_t rate_ = 0;
  bool was_reset_ = false;
  std::vector<std::byte> question_;
  RplidarPackets packets_;
  RplidarPoints points_;
  RplidarInfo info_;
  std::uint16_t mode_ = 0;
  std::uint8_t type_ = rplidar::kPoints;
};

}  // namespace rack::device

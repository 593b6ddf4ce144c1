// Emulator of a Pioneer: SYNC, commands, server information and encoder packets every 100 ms, and
// the watchdog that stops it after two seconds without a packet.
#pragma once

#include "components/devices/chassis/p2os.h"
#include "components/devices/chassis/wheeled_model.h"

namespace rack::device {

class PioneerEmulator final : public WheeledRobot {
 public:
  static constexpr double kTicksOfMillimetre = 48.5;
  static constexpr Duration kWatchdog = std::chrono::seconds(2);

  PioneerEmulator() : WheeledRobot(WheeledModel{400, 1000}) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_packet_; }

  [[nodiscard]] bool is_enabled() const { return enabled_; }
  [[nodiscard]] bool is_open() const { return opened_; }

 private:
  void on_command(std::span<const std::byte> body, Time now, Output& out);
  void apply();
  void send_state(Output& out);
  void send_encoders(Output& out);

  P2osPackets packets_;
  bool opened_ = false;
  bool enabled_ = false;
  bool encoders_ = false;
  bool sonar_ = false;
  int speed_ = 0;
  int turn_ = 0;
  int synced_ = 0;
  Time last_received_{};
  Time next_packet_ = tims::kNever;
};

}  // namespace rack::device

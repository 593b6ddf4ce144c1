// VESC motor controllers by CAN.
//
// A 29-bit identifier is packet << 8 | id; the bytes are big-endian. The controller must be
// configured to send status 1 (9: electrical rpm, current, duty cycle) and status 5 (1B:
// tachometer, voltage) at 50 Hz, and status 4 (10: position) for steering. A controller releases
// its motor after one second without a command (also a setting).
//
// Source: VESC's documentation of its CAN formats; its firmware's list of packets.
#pragma once

#include "components/devices/chassis/motor.h"

namespace rack::device {

enum class VescPacket : std::uint8_t {
  kSetCurrent = 1,
  kSetRpm = 3,
  kSetPosition = 4,
  kStatus1 = 9,
  kStatus4 = 16,
  kStatus5 = 27,
};

constexpr std::uint32_t vesc_id(std::uint8_t node, VescPacket packet) {
  return can::kExtended | static_cast<std::uint32_t>(packet) << 8 | node;
}

struct VescSettings {
  std::uint8_t node = 0;
  MotorTask task = MotorTask::kTurns;
  int pole_pairs = 7;
};

class Vesc final : public Motor {
 public:
  explicit Vesc(const VescSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  bool on_frame(const Arrival& frame, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }
  [[nodiscard]] CanFilter wanted_frames() const override {
    return {.id = vesc_id(settings_.node, {}), .mask = can::kExtended | can::kRemote | 0xFF};
  }
  void command(double target, Time now, Output& out) override;
  void stand(Output& out) const override;
  void stop(Output& out) override;
  [[nodiscard]] bool is_ready() const override { return state_.measured != tims::kNever; }

 private:
  void send(VescPacket packet, std::int32_t value, Output& out, Time deadline = tims::kNever) const;
  void on_tachometer(std::int32_t count);

  VescSettings settings_;
  std::optional<std::int32_t> tachometer_;
  Time next_ = tims::kNever;
};

}  // namespace rack::device

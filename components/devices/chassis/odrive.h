// ODrive (3.x with firmware 0.5, Pro and S1 with 0.6) by CANSimple.
//
// An 11-bit identifier is node << 5 | command; the bytes are little-endian. A drive sends its
// heartbeat (01: errors, state) every 100 ms and its encoder values (09: turns, turns per second)
// every 10 ms. It turns when it is in state 8 (closed loop) and receives a velocity (0D).
// Velocities also feed its watchdog (axis.config.watchdog_timeout, disabled by default): set it to
// 0.2 s.
//
// Source: ODrive's documentation of the CAN protocol, 0.5 and 0.6.
#pragma once

#include "components/devices/chassis/motor.h"

namespace rack::device {

enum class OdriveCommand : std::uint8_t {
  kHeartbeat = 0x01,
  kEmergencyStop = 0x02,
  kAxisState = 0x07,
  kEncoder = 0x09,
  kControllerMode = 0x0B,
  kInputPosition = 0x0C,
  kInputVelocity = 0x0D,
  kBusVoltage = 0x17,
  kClearErrors = 0x18,
};

constexpr std::uint32_t odrive_id(std::uint8_t node, OdriveCommand command) {
  return static_cast<std::uint32_t>(node) << 5 | static_cast<std::uint32_t>(command);
}

class Odrive final : public Motor {
 public:
  Odrive(std::uint8_t node, MotorTask task) : node_(node), task_(task) {}

  void start(Time now, Output& out) override;
  bool on_frame(const Arrival& frame, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }
  [[nodiscard]] CanFilter wanted_frames() const override {
    return {.id = odrive_id(node_, {}), .mask = can::kExtended | can::kRemote | 0x7E0};
  }
  void command(double target, Time now, Output& out) override;
  void stand(Output& out) const override;
  void stop(Output& out) override;
  [[nodiscard]] bool is_ready() const override {
    return axis_state_ == kClosedLoop && state_.measured != tims::kNever;
  }

 private:
  static constexpr std::uint8_t kIdle = 1;
  static constexpr std::uint8_t kClosedLoop = 8;

  void send(OdriveCommand command, std::span<const std::byte> bytes, Output& out,
            Time deadline = tims::kNever) const;
  void ask(OdriveCommand command, Output& out) const;
  void close_loop(Time now, Output& out);
  void on_heartbeat(std::span<const std::byte> bytes, Time when);

  std::uint8_t node_;
  MotorTask task_;
  std::uint8_t axis_state_ = 0;
  Time last_heartbeat_ = tims::kNever;  // time of the last heartbeat
  Time next_ = tims::kNever;
  RetryTimer close_;
  Time next_volts_{};
};

}  // namespace rack::device

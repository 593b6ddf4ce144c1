// Interface of all motor controllers on a CAN bus: commands and state.
#pragma once

#include <optional>
#include <string>

#include "rack/devices/dialogue.h"

namespace rack::device {

enum class MotorTask : std::uint8_t { kTurns, kPositions };  // commands in rad/s, or in rad

// State of the motor's shaft, before any gear.
struct MotorState {
  double position = 0;           // rad
  double velocity = 0;           // rad/s
  double volts = 0;              // supply voltage; 0: unknown
  Time measured = tims::kNever;  // kNever: no data yet
};

class Motor {
 public:
  virtual ~Motor() = default;

  virtual void start(Time now, Output& out) = 0;
  // Returns false if the frame belongs to a different node.
  virtual bool on_frame(const Arrival& frame, Output& out) = 0;
  virtual void on_timeout(Time /*now*/, Output& /*out*/) {}
  [[nodiscard]] virtual Time next_timeout() const { return tims::kNever; }
  // Filter for the frames of this motor; a few other frames may pass.
  [[nodiscard]] virtual CanFilter wanted_frames() const = 0;
  // Must be called several times within 100 ms once the motor is ready: this feeds its watchdog.
  virtual void command(double target, Time now, Output& out) = 0;
  // Stops and releases the motor, independent of the state of the protocol and of the sender.
  virtual void stand(Output& out) const = 0;
  // The same, and sends nothing afterwards.
  virtual void stop(Output& out) = 0;

  // The motor executes commands.
  [[nodiscard]] virtual bool is_ready() const = 0;
  [[nodiscard]] const MotorState& state() const { return state_; }
  // Why it does not; follows the name of the motor in a message: "has stopped sending heartbeats".
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }

 protected:
  // Longer than the pause between two messages of any controller.
  static constexpr Duration kSilenceMax = std::chrono::milliseconds(500);
  // How long a command may wait for the bus; after that, newer commands replace it.
  static constexpr Duration kCommandHolds = std::chrono::milliseconds(50);

  void fail(std::string why) {
    if (!failure_) failure_ = std::move(why);
  }
  void clear() {
    failure_.reset();
    state_ = {};
  }

  MotorState state_;

 private:
  std::optional<std::string> failure_;
};

// An Output that stores telegrams, for example those of Motor::stand().
class KeptTelegrams final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    telegrams_.push_back({.bytes = {bytes.begin(), bytes.end()}, .id = id});
  }
  [[nodiscard]] std::vector<Telegram> take() { return std::exchange(telegrams_, {}); }

 private:
  std::vector<Telegram> telegrams_;
};

namespace can {

// Flags of SocketCAN.
inline constexpr std::uint32_t kExtended = 0x80000000;
inline constexpr std::uint32_t kRemote = 0x40000000;
inline constexpr std::uint32_t kError = 0x20000000;

}  // namespace can

}  // namespace rack::device

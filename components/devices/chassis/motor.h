// A motor controller at a CAN bus, whichever it is: what it is told and what it tells.
#pragma once

#include <optional>
#include <string>

#include "components/devices/core/dialogue.h"

namespace rack::device {

enum class MotorTask : std::uint8_t { kTurns, kPositions };  // it is told rad/s, or rad

// Of its own shaft.
struct MotorState {
  double position = 0;           // rad
  double velocity = 0;           // rad/s
  double volts = 0;              // 0: it does not tell
  Time measured = tims::kNever;  // kNever: nothing yet
};

class Motor {
 public:
  virtual ~Motor() = default;

  virtual void start(Time now, Output& out) = 0;
  // False: the frame is of somebody else.
  virtual bool on_frame(const Arrival& frame, Output& out) = 0;
  virtual void on_timeout(Time /*now*/, Output& /*out*/) {}
  [[nodiscard]] virtual Time next_timeout() const { return tims::kNever; }
  // Of all frames those that are of it, and maybe a few others.
  [[nodiscard]] virtual CanFilter wanted_frames() const = 0;
  // Some times in a tenth of a second, once it is ready: its watchdog lives on it.
  virtual void command(double target, Time now, Output& out) = 0;
  // It stops and is released, whatever it was told before, and whoever says it.
  virtual void stand(Output& out) const = 0;
  // The same, and nothing is said any more.
  virtual void stop(Output& out) = 0;

  // It does what it is told.
  [[nodiscard]] virtual bool is_ready() const = 0;
  [[nodiscard]] const MotorState& state() const { return state_; }
  // Why it does not, behind its name: "is silent for 500 ms".
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }

 protected:
  // Longer than any of them is silent.
  static constexpr Duration kSilenceMax = std::chrono::milliseconds(500);
  // How long a command can wait for a bus: then newer ones wait behind it.
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

// What motors are told, kept for later.
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

// As SocketCAN has them.
inline constexpr std::uint32_t kExtended = 0x80000000;
inline constexpr std::uint32_t kRemote = 0x40000000;
inline constexpr std::uint32_t kError = 0x20000000;

}  // namespace can

}  // namespace rack::device

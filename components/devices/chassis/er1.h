// The robot control module of an Evolution Robotics ER1: two motors, each with a PMD Navigator
// motion processor, on one serial line at 250 kbaud.
//
// A command is address, checksum, axis (0), code, and up to three 16 bit values, high byte first;
// the bytes of a command add up to 0. The processor answers with a status (0: success), a checksum
// of the same kind, and optional 16 bit values. Address 0 is the right wheel, address 1 the left
// one, which is mounted in reverse. Set values take effect with Update (1A). The wheels keep
// turning without commands, so the driver has a guard that sends er1_stop().
//
// An answer contains neither its request nor the speed of the wheels. In a replay, these are taken
// from the recorded commands.
//
// Source: PMD's Navigator programmer's reference; RACK 0.6.1. The latter shifted the upper 16 bits
// of a velocity by 8 bits only, so that its velocities were 256 times the intended ones; with the
// same velFactor this driver sends the same values.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "components/devices/chassis/chassis_control.h"
#include "rack/devices/stream_buffer.h"

namespace rack::device {

enum class Er1Code : std::uint8_t {
  kSetVelocity = 0x11,
  kUpdate = 0x1A,
  kGetActualPosition = 0x37,
  kReset = 0x39,
  kSetMotorCommand = 0x77,  // motor power
  kSetLimitSwitchMode = 0x80,
  kSetAcceleration = 0x90,
  kSetDeceleration = 0x91,
  kSetProfileMode = 0xA0,
};

struct Er1Command {
  std::uint8_t address = 0;
  Er1Code code = Er1Code::kUpdate;
  std::int32_t value = 0;

  static constexpr std::size_t kSizeMax = 8;
  struct Bytes {
    std::array<std::byte, kSizeMax> bytes{};
    std::size_t size = 0;
    [[nodiscard]] std::span<const std::byte> view() const { return std::span(bytes).first(size); }
  };
  [[nodiscard]] Bytes encode() const;
  // Empty if the bytes are not exactly one valid command.
  static std::optional<Er1Command> decode(std::span<const std::byte> bytes);
};
// Sizes of the value of a command, and of its answer without status and checksum, bytes.
std::size_t er1_value_size(Er1Code code);
std::size_t er1_answer_size(Er1Code code);

// The commands that stop both wheels.
std::vector<std::byte> er1_stop();

struct Er1Settings {
  double axis_width = 380;       // mm
  double velocity_factor = 764;  // velocity units of the processor per mm/s
  // Actual speed of the wheels, mm/s: factor x commanded speed - offset.
  double odometry_factor = 1.17;
  double odometry_offset = 40;
  double ticks_per_mm = 0;   // encoder ticks; 0: encoders are not read
  double omega_min = 0.26;   // rad/s; slower turns on the spot do not move the robot
  bool only_listen = false;  // the device is a recording
};

class Er1 final : public ChassisDialogue {
 public:
  explicit Er1(const Er1Settings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void on_sent(const Arrival& arrival) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> stop_commands() const override {
    return {{.bytes = er1_stop()}};
  }

  void drive(const ChassisSpeed& speed, Time now) override;
  [[nodiscard]] bool is_ready() const override { return is_set_up_; }
  bool take(ChassisData& data, Time& recorded) override;

 private:
  enum Wheel : std::size_t { kRight = 0, kLeft = 1 };

  [[nodiscard]] std::size_t count() const;
  [[nodiscard]] Er1Command command(std::size_t index) const;
  void next_command(Time now, Output& out);
  void ask(Time now, Output& out);
  void on_answer(std::span<const std::byte> answer, Time now);
  void on_round(Time now);
  [[nodiscard]] double really(double speed) const;

  Er1Settings settings_;
  bool is_set_up_ = false;
  std::size_t index_ = 0;     // index of the command in this round
  bool is_asking_ = false;    // waiting for an answer
  bool is_in_round_ = false;  // the start of a round was found in the recording
  Time round_{};
  StreamBuffer answer_{64};

  std::array<double, 2> wanted_{};   // mm/s, by Wheel
  std::array<double, 2> sending_{};  // mm/s, sent in this round
  std::array<double, 2> confirmed_{};
  std::array<std::optional<std::int32_t>, 2> counts_{};
  std::array<double, 2> distances_{};  // distances since the last data, mm
  Time confirmed_since_{};

  bool has_data_ = false;
  ChassisData data_;
  Time recorded_{};
};

}  // namespace rack::device

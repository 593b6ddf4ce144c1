// The robot control module of an Evolution Robotics ER1: two motors, each with a motion processor
// of PMD (Navigator), on one serial line at 250 kbaud.
//
// A command is address, checksum, axis (0), code, and up to three words, high byte first; the bytes
// of a command add up to 0. The processor answers with a status (0 is good), a checksum of the same
// kind, and words when there are some. Address 0 turns the right wheel, address 1 the left one,
// which is built in the other way round. What was set becomes true with Update (1A). It goes on
// turning when the host is silent, so the driver has a guard that says er1_stop().
//
// An answer says neither what was asked nor how fast the wheels turn: a recording tells by what was
// said to the processors then.
//
// Source: PMD's Navigator programmer's reference; what RACK 0.6.1 sends. That program shifted the
// upper word of a velocity by 8 bits only, so that its velocities were 256 times what it meant:
// with the same velFactor this one sends the same.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "components/devices/chassis/chassis_control.h"
#include "components/devices/core/stream_buffer.h"

namespace rack::device {

enum class Er1Code : std::uint8_t {
  kSetVelocity = 0x11,
  kUpdate = 0x1A,
  kGetActualPosition = 0x37,
  kReset = 0x39,
  kSetMotorCommand = 0x77,  // the power
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
  // Nothing: it is not one command, or a broken one.
  static std::optional<Er1Command> decode(std::span<const std::byte> bytes);
};
// Of the value, and of what the answer has besides status and checksum.
std::size_t er1_value_size(Er1Code code);
std::size_t er1_answer_size(Er1Code code);

// What stops both wheels.
std::vector<std::byte> er1_stop();

struct Er1Settings {
  double axis_width = 380;       // mm
  double velocity_factor = 764;  // of the processor for 1 mm/s
  // What the wheels really do, mm/s: factor x speed - offset.
  double odometry_factor = 1.17;
  double odometry_offset = 40;
  double ticks_per_mm = 0;   // of the processor's counters; 0: none are asked for
  double omega_min = 0.26;   // rad/s; less of it on the spot does not turn the robot
  bool only_listen = false;  // to a recording
};

class Er1 final : public ChassisDialogue {
 public:
  explicit Er1(const Er1Settings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void on_sent(const Arrival& words) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> last_words() const override {
    return {{.bytes = er1_stop()}};
  }
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

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
  std::size_t index_ = 0;     // of the command in this round
  bool is_asking_ = false;    // an answer is missing
  bool is_in_round_ = false;  // of a recording
  int attempts_ = 0;
  Time timeout_ = tims::kNever;
  Time round_{};
  StreamBuffer answer_{64};

  std::array<double, 2> wanted_{};   // mm/s, by Wheel
  std::array<double, 2> sending_{};  // in this round
  std::array<double, 2> confirmed_{};
  std::array<std::optional<std::int32_t>, 2> counts_{};
  std::array<double, 2> ways_{};  // since the last data, mm
  Time confirmed_since_{};

  bool has_data_ = false;
  ChassisData data_;
  Time recorded_{};
};

}  // namespace rack::device

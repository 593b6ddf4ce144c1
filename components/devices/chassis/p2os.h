// MobileRobots robots with P2OS (ARCOS, AROS and others): Pioneer 2 and 3, PeopleBot.
//
// A packet is FA FB, the number of bytes that follow, the bytes, and a checksum: the sum of their
// pairs, high byte first, a last odd byte XORed. The host sends SYNC 0, 1, 2, which the robot
// returns, the last one with its names; then commands: a number, and an argument with its type (3B:
// not negative, 1B: negative, 2B: text). The pause between two commands is 10 ms. After OPEN the
// robot sends a server information packet (32 at rest, 33 in motion) every 100 ms, and encoder
// packets (90) on request. After two seconds without a packet (a setting of the robot) it stops:
// this is the protection against a crash of the host.
//
// Source: Pioneer 3 operations manual, chapter 6; RACK 0.6.1.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "components/devices/chassis/chassis_control.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

enum class P2osCommand : std::uint8_t {
  kPulse = 0,  // also SYNC0
  kOpen = 1,
  kClose = 2,
  kEnable = 4,
  kSetAcceleration = 5,  // mm/s2; below 0: deceleration
  kVelocity = 11,        // mm/s
  kEncoder = 19,         // 0 none, 1 one, 2 all
  kTurn = 21,            // deg/s, counterclockwise
  kSonar = 28,
};

// A packet in a fixed buffer, without dynamic memory.
struct P2osPacket {
  static constexpr std::size_t kSizeMax = 12;
  std::array<std::byte, kSizeMax> bytes{};
  std::size_t size = 0;
  [[nodiscard]] std::span<const std::byte> view() const { return std::span(bytes).first(size); }
};
std::uint16_t p2os_checksum(std::span<const std::byte> body);
P2osPacket p2os_command(P2osCommand command, std::optional<int> argument = {});
P2osPacket p2os_sync(int number);

// Splits a stream into packets and returns their bodies, without frame and checksum.
class P2osPackets {
 public:
  struct Packet {
    std::span<const std::byte> body{};
    Time began{};
  };
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Returns false if there is no complete packet. The packet is valid until the next call.
  bool next(Packet& packet);
  void clear() { buffer_.clear(); }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kSizeMax = 258;
  StreamBuffer buffer_{4 * kSizeMax};
  std::size_t used_ = 0;
  std::uint64_t broken_ = 0;
};

inline constexpr std::size_t kP2osSonars = 16;

// The part of a server information packet that RACK uses.
struct P2osState {
  bool is_moving = false;
  int x = 0;  // mm, odometry of the robot
  int y = 0;
  int heading = 0;  // 4096 per turn, counterclockwise
  float left = 0;   // mm/s
  float right = 0;
  float battery = 0;  // V
  struct Sonar {
    std::uint8_t number;
    std::uint16_t range;  // raw value
  };
  std::array<Sonar, kP2osSonars> sonars{};
  std::size_t sonar_count = 0;
};
bool decode_p2os_state(std::span<const std::byte> body, P2osState& state);

struct P2osSettings {
  bool sonar = false;
  double ticks_per_mm = 48.5;   // encoder ticks; Pioneer 3-DX: 128
  double rotation_width = 400;  // effective distance of the wheels, mm
  double sonar_scale = 0.268;   // mm per unit; Pioneer 3: 1
  int acceleration = 0;         // mm/s2; 0: setting of the robot
  int deceleration = 0;
  bool only_listen = false;  // the device is a recording
};

class P2os final : public ChassisDialogue {
 public:
  explicit P2os(const P2osSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;

  void drive(const ChassisSpeed& speed, Time now) override;
  [[nodiscard]] bool is_ready() const override { return state_ == State::kOpen; }
  bool take(ChassisData& data, Time& recorded) override;
  // Takes the sonars as rays around the robot, if there are new measurements.
  bool take_sonars(LadarData& rays, Time& recorded);

  // "name type subtype", after the connection was opened.
  [[nodiscard]] const std::string& robot() const { return robot_; }

 private:
  // In the order of the connection setup.
  enum class State : std::uint8_t { kSync0, kSync1, kSync2, kSetup, kOpen };

  void enter(State state, Time now);
  void send(const P2osPacket& packet, Time now, Output& out);
  void send_setup(Time now, Output& out);
  void send_speed(Time now, Output& out);
  void on_packet(const P2osPackets::Packet& packet, Time now);
  void on_sync(std::span<const std::byte> body, Time now);
  void on_state(const P2osState& state, Time began);
  void on_encoders(std::span<const std::byte> body);

  P2osSettings settings_;
  State state_ = State::kSync0;
  int step_ = 0;  // step of the setup
  P2osPackets packets_;
  std::string robot_;

  int wanted_speed_ = 0;  // mm/s
  int wanted_turn_ = 0;   // deg/s
  std::optional<int> sent_speed_;
  std::optional<int> sent_turn_;
  Time repeat_{};  // when to repeat both

  std::optional<std::array<std::int32_t, 2>> encoders_;  // left, right
  std::array<double, 2> distances_{};                    // distances of the wheels since last data
  std::optional<std::array<int, 3>> pose_;               // used until encoder packets arrive

  bool has_data_ = false;
  ChassisData data_;
  bool has_sonars_ = false;
  LadarData rays_;
  Time recorded_{};
  Time recorded_before_{};
};

}  // namespace rack::device

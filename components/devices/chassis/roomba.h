// iRobot Roomba (the open interface of the 400 series) and Create 2, Roomba 600 and later.
//
// The host sends an opcode and its data, high byte first; there are no acknowledgements. 80 starts
// the interface, 82 and 84 give the host full control, 89 drives (speed and radius), 91 drives each
// wheel (Create 2), 8A switches brushes and vacuum, 8F seeks the dock. The sensors of the older
// model are polled (8E 00, 26 bytes without a frame). The newer model sends a frame every 15 ms
// (94): 13, number of bytes, packets with their ids, and a checksum that makes the sum 0.
//
// Neither model has a watchdog. The driver therefore has a guard (io/guard.h) that sends
// kRoombaStop when the driver crashes.
//
// Source: iRobot's open interface specifications of both; RACK 0.6.1.
#pragma once

#include <array>
#include <optional>

#include "components/devices/chassis/chassis_control.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/scan2d.h"

namespace rack::device {

enum class RoombaModel : std::uint8_t { kRoomba, kCreate2 };

// The sensors of both models that RACK uses.
struct RoombaSensors {
  std::uint8_t bumps = 0;  // bits: 1 right, 2 left, 4 and higher: wheel drop
  bool wall = false;
  std::array<bool, 4> cliffs{};   // left, front left, front right, right
  std::uint8_t overcurrents = 0;  // bits: 1 side brush, 2 vacuum, 4 main brush, 8 right, 16 left
  std::uint8_t charging = 0;
  float battery = 0;                 // V
  std::array<float, 2> distances{};  // distances of left and right wheel since the last sensors, mm
};

// Decodes packet group 0, 26 bytes. Returns false if the values are implausible. track: distance of
// the wheels, mm.
bool decode_roomba_sensors(std::span<const std::byte> bytes, double track, RoombaSensors& sensors);

// Decodes the frames of a Create 2; converts encoder counts to distances.
class Create2Frames {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Returns false if there is no complete frame.
  bool next(RoombaSensors& sensors, Time& began);
  void clear();
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  StreamBuffer buffer_{256};
  std::optional<std::array<std::uint16_t, 2>> counts_;
  std::uint64_t broken_ = 0;
};
// The requested packets, in order.
inline constexpr std::array<std::uint8_t, 11> kCreate2Packets = {7,  8,  9,  10, 11, 12,
                                                                 14, 21, 22, 43, 44};
std::size_t create2_packet_size(std::uint8_t id);
inline constexpr double kCreate2MillimetresOfCount = 3.14159265358979 * 72.0 / 508.8;

// Drive with speed 0, repeated: the first bytes complete a command that may have been cut off.
inline constexpr std::array<std::byte, 20> kRoombaStop = [] {
  std::array<std::byte, 20> bytes{};
  for (std::size_t i = 0; i < bytes.size(); i += 5) bytes[i] = std::byte{0x89};
  return bytes;
}();

struct RoombaSettings {
  RoombaModel model = RoombaModel::kRoomba;
  double track = 258;  // mm; Create 2: 235
  bool main_brush = false;
  bool vacuum = false;
  bool side_brush = false;
  bool dock = false;
  bool only_listen = false;  // the device is a recording
};

class Roomba final : public ChassisDialogue {
 public:
  explicit Roomba(const RoombaSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> stop_commands() const override {
    return {{.bytes = {kRoombaStop.begin(), kRoombaStop.end()}}};
  }
  [[nodiscard]] Time next_timeout() const override;

  void drive(const ChassisSpeed& speed, Time now) override;
  [[nodiscard]] bool is_ready() const override { return is_running_; }
  bool take(ChassisData& data, Time& recorded) override;
  // Adds bumper contacts and cliffs as points around the robot.
  void look(Scan2dData& scan) const;
  [[nodiscard]] const RoombaSensors& sensors() const { return sensors_; }

 private:
  void setup(Time now, Output& out);
  void send_speed(Time now, Output& out);
  void on_sensors(const RoombaSensors& sensors, Time measured);
  template <typename... Bytes>
  void send(Output& out, Bytes... bytes);

  RoombaSettings settings_;
  int step_ = 0;  // step of the setup
  bool is_running_ = false;
  bool asked_ = false;  // sensors were requested in this period
  Time next_step_ = tims::kNever;
  Time next_drive_ = tims::kNever;
  Time last_drive_{};

  ChassisSpeed wanted_;
  StreamBuffer answer_{64};
  Create2Frames frames_;
  RoombaSensors sensors_;
  Time overcurrent_since_ = tims::kNever;

  bool has_data_ = false;
  ChassisData data_;
  double distance_ = 0;  // distance since the last data, mm
  double turn_ = 0;      // rad
  Time recorded_{};
  Time recorded_before_{};
};

}  // namespace rack::device

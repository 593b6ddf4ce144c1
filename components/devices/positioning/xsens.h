// Xsens MTi and MTx: inertial measurement units on a serial line.
//
// A message is FA, FF, id, length, data, checksum; all bytes after FA, including the checksum, add
// up to 0 (modulo 256). Length FF means that a length of two bytes follows. Numbers are big-endian.
// The device is configured in configuration state (after 30), then it is set to measurement (10).
// There are two generations: MTData (32) has a configured order of values; MTData2 (36) is a list
// of items, each with type and length.
//
// The original does not configure the device, accepts wrong checksums, and scales rates of turn as
// if they were degrees. This dialogue rejects wrong checksums and keeps rates in rad/s.
//
// Source: Xsens' "MT Low Level Communication Protocol"; messages of an MTi-300 with their decoding
// by the manufacturer's program.
#pragma once

#include <array>
#include <optional>

#include "rack/devices/device_clock.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/gyro.h"

namespace rack::device {

namespace xsens {
inline constexpr std::uint8_t kAskIdentity = 0x00;
inline constexpr std::uint8_t kToMeasurement = 0x10;
inline constexpr std::uint8_t kToConfiguration = 0x30;
inline constexpr std::uint8_t kData = 0x32;
inline constexpr std::uint8_t kData2 = 0x36;
inline constexpr std::uint8_t kError = 0x42;
inline constexpr std::uint8_t kSetPeriod = 0x04;
inline constexpr std::uint8_t kSetOutput = 0xC0;  // for MTData2
inline constexpr std::uint8_t kSetMode = 0xD0;    // for MTData
inline constexpr std::uint8_t kSetSettings = 0xD2;
inline constexpr std::uint8_t kAnswers = 1;  // id of an answer minus id of its request

inline constexpr std::uint16_t kPacketCounter = 0x1020;
inline constexpr std::uint16_t kSampleTime = 0x1060;  // 0.1 ms
inline constexpr std::uint16_t kQuaternion = 0x2010;
inline constexpr std::uint16_t kEuler = 0x2030;
inline constexpr std::uint16_t kAcceleration = 0x4020;
inline constexpr std::uint16_t kRateOfTurn = 0x8020;
// Bits of an orientation item: the reference frame.
inline constexpr std::uint16_t kFrameMask = 0x000C;
inline constexpr std::uint16_t kEastNorthUp = 0x0000;
inline constexpr std::uint16_t kNorthEastDown = 0x0004;
inline constexpr std::uint16_t kNorthWestUp = 0x0008;
}  // namespace xsens

struct XsensMessage {
  std::uint8_t number = 0;
  std::span<const std::byte> data{};  // valid until the next call
  Time began{};
};

void append_xsens(std::vector<std::byte>& out, std::uint8_t number,
                  std::span<const std::byte> data = {});

class XsensMessages {
 public:
  // Maximum size of a piece; call next() until it returns false before adding more.
  static constexpr std::size_t kPieceMax = 1024;

  void add(const Arrival& arrival) { buffer_.add(arrival); }
  bool next(XsensMessage& message);
  void clear();

  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kDataMax = 2048;

  StreamBuffer buffer_{2 * (kDataMax + 7)};
  std::size_t used_ = 0;
  std::uint64_t broken_ = 0;
};

// One measurement in the axes and units of the device.
struct XsensSample {
  struct Vector {
    double x = 0;
    double y = 0;
    double z = 0;
  };
  struct Rotation {  // quaternion: orientation of the device in its Earth frame
    double w = 1;
    double x = 0;
    double y = 0;
    double z = 0;
  };

  std::optional<Vector> acceleration{};  // m/s2
  std::optional<Vector> rate{};          // rad/s
  std::optional<Rotation> orientation{};
  std::optional<Vector> euler{};  // rad: roll, pitch, yaw reported by the device
  std::uint16_t frame = xsens::kNorthWestUp;
  std::optional<std::uint64_t> counter{};  // MTData2: 0.1 ms; MTData: samples

  bool operator==(const XsensSample&) const = delete;
};

// Returns false for messages this program has not configured. MTData contains calibrated data,
// Euler angles or a quaternion, and optionally a counter; its length determines which.
bool decode_xsens(const XsensMessage& message, XsensSample& sample);

// Mounting of the device.
enum class XsensMounting : std::uint8_t {
  kUnchanged,  // as the original: angles and rates unchanged, x forward and z down
  kLabelUp,    // usual mounting; converted to angles of the robot with heading 0 to the north
  kLabelDown,
};
// Converts a sample to data; returns false if a value is missing. Accelerations have the sign of
// the original, that of the force on a mass in the robot: gravity is +9810 mm/s2 in z.
bool to_gyro(const XsensSample& sample, XsensMounting mounting, GyroData& data);

struct XsensSettings {
  Duration period = std::chrono::milliseconds(10);
  XsensMounting mounting = XsensMounting::kUnchanged;
  std::uint32_t baud = 115200;  // for error messages only
  std::string serial_number{};  // required device id, hexadecimal; empty: any
  bool only_listen = false;     // the device is a recording
};

class Xsens final : public Dialogue {
 public:
  explicit Xsens(const XsensSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return state_ == State::kMeasuring; }
  bool take(GyroData& data, Time& recorded);
  // Empty if the device has not reported one.
  [[nodiscard]] const std::string& serial_number() const { return serial_number_; }
  [[nodiscard]] const XsensMessages& messages() const { return messages_; }
  [[nodiscard]] std::uint64_t broken() const { return messages_.broken(); }

 private:
  // In the order of the setup: kOutput is used with MTData2, the three states after it with MTData.
  enum class State : std::uint8_t {
    kConfiguration,
    kIdentity,
    kOutput,
    kPeriod,
    kMode,
    kSettings,
    kStart,
    kMeasuring
  };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void on_message(const XsensMessage& message, Output& out);
  void on_answer(const XsensMessage& message, Output& out);
  void identified(Time now, Output& out);
  void on_refusal(const XsensMessage& message, Output& out);
  void take_sample(const XsensMessage& message);
  Time measured_at(const XsensMessage& message, const XsensSample& sample);

  XsensSettings settings_;
  State state_ = State::kConfiguration;
  bool sends_data_ = false;  // data are received, with or without answers
  std::uint8_t asked_ = 0;
  std::string serial_number_;
  XsensMessages messages_;
  std::vector<std::byte> question_;
  std::vector<std::byte> body_;
  std::optional<DeviceClock> clock_;
  bool clock_counts_time_ = false;
  bool has_data_ = false;
  GyroData data_{};
  Time recorded_{};
};

}  // namespace rack::device

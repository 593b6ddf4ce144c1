// The bytes of Slamtec's RPLIDAR (A, S, C series).
//
// The host says A5, a command, and for commands from 80 on a length, that many bytes, and the
// exclusive or of all of it. An answer begins with A5 5A, a length of 30 bits with two bits that
// tell whether one or many follow, and a type; then come the bytes. Measurements follow without
// end:
//
//   81  5 bytes: one point. Its start bit and the opposite, quality, a bit that is set, the angle
//       in 1/64 degree, the distance in 1/4 mm
//   82  84 bytes, 32 points in 16 pairs: distances in mm, how far each angle is off in 1/8 degree
//   84  132 bytes, 96 points in 32 triples: one distance of variable scale, and how much the next
//       two differ from their neighbours
//   85  84 bytes, 40 points: distances in mm
//
// The last three begin with A and 5, a sum in the halves beside them, and the angle of their first
// point; where their points lie is known when the next one has told its angle.
//
// Source: Slamtec, "Interface Protocol and Application Notes" (A3, 2019; LR001); the angles of 84
// and the sign of 82 (it has none, although the manual says so) as all public decoders have them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "components/devices/core/stream_buffer.h"
#include "components/devices/scanners/turning_ladar.h"

namespace rack::device {

namespace rplidar {
inline constexpr std::uint8_t kStop = 0x25;
inline constexpr std::uint8_t kReset = 0x40;
inline constexpr std::uint8_t kScan = 0x20;
inline constexpr std::uint8_t kInfo = 0x50;
inline constexpr std::uint8_t kHealth = 0x52;
inline constexpr std::uint8_t kExpress = 0x82;
inline constexpr std::uint8_t kConfiguration = 0x84;
inline constexpr std::uint8_t kSpeed = 0xA8;  // turns a minute
inline constexpr std::uint8_t kMotor = 0xF0;  // 0 to 1023

inline constexpr std::uint8_t kInfoAnswer = 0x04;
inline constexpr std::uint8_t kHealthAnswer = 0x06;
inline constexpr std::uint8_t kConfigurationAnswer = 0x20;
inline constexpr std::uint8_t kPoints = 0x81;
inline constexpr std::uint8_t kPairs = 0x82;
inline constexpr std::uint8_t kTriples = 0x84;
inline constexpr std::uint8_t kDense = 0x85;

// What kConfiguration is asked for; those with a mode have it behind them.
inline constexpr std::uint32_t kRangeOfMode = 0x74;
inline constexpr std::uint32_t kAnswerOfMode = 0x75;
inline constexpr std::uint32_t kTypicalMode = 0x7C;
}  // namespace rplidar

// Appends a command.
void append_rplidar(std::vector<std::byte>& out, std::uint8_t command,
                    std::span<const std::byte> payload = {});
// Appends what an answer begins with.
void append_rplidar_answer(std::vector<std::byte>& out, std::uint8_t type, std::uint32_t size,
                           bool many);
// Writes the first two bytes of 82, 84 and 85: of all that stands behind them.
void seal_rplidar_capsule(std::span<std::byte> capsule);

// The twelve bits of a distance in 84: small ones exactly, large ones by 2, 4, 8, 16 mm.
struct RplidarScaled {
  std::int32_t distance = 0;
  int shift = 0;
};
RplidarScaled rplidar_scaled(std::uint32_t bits);

struct RplidarPacket {
  std::uint8_t type = 0;
  std::span<const std::byte> data{};
  Time began{};
  bool follows = true;  // nothing was lost between the measurement before and this one
};

class RplidarPackets {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Answers and measurements, in order. Valid until the next call.
  bool next(RplidarPacket& packet);
  void clear();

  // Bytes that belong to nothing while measurements come.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  enum class What : std::uint8_t { kNothing, kPacket, kSkip };

  What take_answer(std::span<const std::byte> bytes, RplidarPacket& packet);
  What take_measurement(std::span<const std::byte> bytes, RplidarPacket& packet);
  [[nodiscard]] bool is_measurement(std::span<const std::byte> bytes) const;

  static constexpr std::size_t kLongest = 1 << 16;

  StreamBuffer buffer_{kLongest};
  std::uint8_t stream_ = 0;  // type of the measurements that come; 0: none
  std::size_t size_ = 0;     // of one of them
  bool is_in_step_ = false;
  bool follows_ = false;
  std::size_t used_ = 0;
  std::uint64_t lost_ = 0;
};

// Measurements become points.
class RplidarPoints {
 public:
  void decode(const RplidarPacket& packet, TurningScan& scan);
  void clear() { before_size_ = 0; }

 private:
  void decode_point(const RplidarPacket& packet, TurningScan& scan);
  void decode_pairs(TurningScan& scan) const;
  void decode_triples(std::span<const std::byte> next, TurningScan& scan) const;
  void decode_dense(TurningScan& scan) const;
  [[nodiscard]] f32 angle_of(std::size_t point, double offset = 0) const {
    return static_cast<f32>(first_ + step_ * static_cast<double>(point) - offset);
  }

  static constexpr std::size_t kLongest = 132;

  std::array<std::byte, kLongest> before_{};  // the packet whose angles are not known yet
  std::size_t before_size_ = 0;
  std::uint8_t before_type_ = 0;
  Time before_time_{};
  double first_ = 0;  // of its points, rad
  double step_ = 0;
  Time began_{};
  Duration step_time_{};
};

}  // namespace rack::device

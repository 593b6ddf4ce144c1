// The protocol of Slamtec's RPLIDAR (A, S, C series).
//
// The host sends A5, a command, and for commands from 80 on a length, that many bytes, and the XOR
// of all bytes. An answer begins with A5 5A, a length of 30 bits with two bits that distinguish
// single from repeated answers, and a type, followed by the data. Measurements are repeated
// answers:
//
//   81  5 bytes: one point. Start bit and its inverse, quality, a bit that is always set, the angle
//       in 1/64 degree, the distance in 1/4 mm
//   82  84 bytes, 32 points in 16 pairs: distances in mm, angle offset of each point in 1/8 degree
//   84  132 bytes, 96 points in 32 triples: one distance with variable scale, and the differences
//   of
//       the next two to their neighbours
//   85  84 bytes, 40 points: distances in mm
//
// The last three begin with the nibbles A and 5, a checksum in the other two nibbles, and the angle
// of their first point. The angles of the other points are interpolated when the next packet
// arrives.
//
// Source: Slamtec, "Interface Protocol and Application Notes" (A3, 2019; LR001). The angles of 84,
// and the offsets of 82 (unsigned, although the manual says signed), are those of all public
// decoders.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "components/devices/scanners/turning_ladar.h"
#include "rack/devices/stream_buffer.h"

namespace rack::device {

namespace rplidar {
inline constexpr std::uint8_t kStop = 0x25;
inline constexpr std::uint8_t kReset = 0x40;
inline constexpr std::uint8_t kScan = 0x20;
inline constexpr std::uint8_t kInfo = 0x50;
inline constexpr std::uint8_t kHealth = 0x52;
inline constexpr std::uint8_t kExpress = 0x82;
inline constexpr std::uint8_t kConfiguration = 0x84;
inline constexpr std::uint8_t kSpeed = 0xA8;  // turns per minute
inline constexpr std::uint8_t kMotor = 0xF0;  // 0 to 1023

inline constexpr std::uint8_t kInfoAnswer = 0x04;
inline constexpr std::uint8_t kHealthAnswer = 0x06;
inline constexpr std::uint8_t kConfigurationAnswer = 0x20;
inline constexpr std::uint8_t kPoints = 0x81;
inline constexpr std::uint8_t kPairs = 0x82;
inline constexpr std::uint8_t kTriples = 0x84;
inline constexpr std::uint8_t kDense = 0x85;

// Items requested by kConfiguration; those of a mode are followed by its number.
inline constexpr std::uint32_t kRangeOfMode = 0x74;
inline constexpr std::uint32_t kAnswerOfMode = 0x75;
inline constexpr std::uint32_t kTypicalMode = 0x7C;
}  // namespace rplidar

// Appends a command.
void append_rplidar(std::vector<std::byte>& out, std::uint8_t command,
                    std::span<const std::byte> payload = {});
// Appends the header of an answer.
void append_rplidar_answer(std::vector<std::byte>& out, std::uint8_t type, std::uint32_t size,
                           bool many);
// Writes the checksum of all following bytes to the first two bytes of 82, 84 and 85.
void seal_rplidar_capsule(std::span<std::byte> capsule);

// Decodes the twelve bits of a distance in 84: exact for small distances, in steps of 2, 4, 8 or 16
// mm for larger ones.
struct RplidarScaled {
  std::int32_t distance = 0;
  int shift = 0;
};
RplidarScaled rplidar_scaled(std::uint32_t bits);

struct RplidarPacket {
  std::uint8_t type = 0;
  std::span<const std::byte> data{};
  Time began{};
  bool follows = true;  // nothing was lost since the previous measurement
};

class RplidarPackets {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Returns answers and measurements in order. The packet is valid until the next call.
  bool next(RplidarPacket& packet);
  void clear();

  // Number of bytes between measurements that belong to no packet.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  enum class What : std::uint8_t { kNothing, kPacket, kSkip };

  What take_answer(std::span<const std::byte> bytes, RplidarPacket& packet);
  What take_measurement(std::span<const std::byte> bytes, RplidarPacket& packet);
  [[nodiscard]] bool is_measurement(std::span<const std::byte> bytes) const;

  static constexpr std::size_t kLongest = 1 << 16;

  StreamBuffer buffer_{kLongest};
  std::uint8_t stream_ = 0;  // type of the current measurements; 0: none
  std::size_t size_ = 0;     // size of one measurement
  bool is_in_step_ = false;
  bool follows_ = false;
  std::size_t used_ = 0;
  std::uint64_t lost_ = 0;
};

// Converts measurements to points.
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

  std::array<std::byte, kLongest> before_{};  // the packet whose angles are not yet known
  std::size_t before_size_ = 0;
  std::uint8_t before_type_ = 0;
  Time before_time_{};
  double first_ = 0;  // angle of its first point, rad
  double step_ = 0;
  Time began_{};
  Duration step_time_{};
};

}  // namespace rack::device

// SICK picoScan100 and multiScan100, which send their scans by UDP (port 2115), in parts: segments
// of a turn, a datagram each, in SICK's format "Compact".
//
//    0  02 02 02 02, what it is (u32; 1 a segment, 2 the inertial unit), counter (u64),
//       time of sending (u64, us), version (u32; 3 or 4), size of the first module (u32)
//   32  modules, one after the other, and CRC-32 of all that (u32)
//
// A module has some layers with equally many beams each: segment and frame (turn) number (u64
// each), serial number, layers, beams, echoes (u32 each), then for each layer the time of its first
// and of its last beam (u64, us), its elevation, and the azimuths of both beams (f32, rad), then
// the factor of distances (f32, version 4 only), size of the next module (u32; 0: this was the
// last), four bytes that say what comes of an echo and of a beam, and beam by beam, layer by layer:
// distance and remission (u16 each) of every echo, a byte of flags and an azimuth (u16), in version
// 3 the other way round. All of it little-endian; angles count counter-clockwise from ahead.
//
// Where the segments are sent to, and that they are, is the scanner's own setting: on its web page,
// or by CoLa A at TCP port 2111, ScanDataEthSettings (1 for UDP, the four numbers of the address,
// the port), ScanDataFormat (2 for Compact) and ScanDataEnable. A driver that only listens does not
// change for whom else it sends.
//
// Sources: SICK's "Data format description Compact"; its ScanSegmentAPI and sick_scan_xd.
#pragma once

#include <vector>

#include "components/devices/core/device_clock.h"
#include "components/devices/core/dialogue.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

struct CompactBeam {
  float azimuth = 0;           // rad, counter-clockwise
  std::uint32_t distance = 0;  // mm, of the first echo; 0: there is none
  std::uint16_t remission = 0;
  bool is_reflector = false;
};

// Of the most level layer in it.
struct CompactSegment {
  std::uint64_t counter = 0;
  std::uint64_t transmitted = 0;  // us
  std::uint64_t frame_number = 0;
  std::uint32_t serial_number = 0;
  std::uint64_t started = 0;  // us: its first beam and its last
  std::uint64_t stopped = 0;
  float elevation = 0;
  std::vector<CompactBeam> beams{};
};

std::uint32_t crc32(std::span<const std::byte> bytes);

enum class CompactKind : std::uint8_t { kBroken, kSegment, kOther };
// Allocates nothing when `segment` has the room.
CompactKind decode_compact(std::span<const std::byte> datagram, CompactSegment& segment);

struct SickCompactSettings {
  std::uint32_t serial_number = 0;  // of the only scanner that is heard; 0: any
  std::int32_t max_range = 75000;   // mm
};

// Listens only: to a recording it is the same.
class SickCompact final : public Dialogue {
 public:
  explicit SickCompact(const SickCompactSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  // From the first turn on, which was joined within and is no scan.
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(LadarData& scan, Time& recorded);

  // Of whom the newest datagram is.
  [[nodiscard]] std::string serial_number() const { return std::to_string(segment_.serial_number); }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  void take_segment(Time arrived);
  void begin_frame();
  void finish_frame(Time arrived);
  [[nodiscard]] std::string complaint() const;

  SickCompactSettings settings_;
  DeviceClock clock_;
  CompactSegment segment_;
  bool is_ready_ = false;
  Time timeout_ = tims::kNever;
  // What came instead of scans.
  std::uint64_t datagrams_ = 0;
  std::uint64_t broken_ = 0;
  std::uint64_t of_others_ = 0;

  // The turn that is put together.
  bool has_frame_ = false;
  bool is_finished_ = false;  // and what comes of it now is too much
  std::uint64_t frame_number_ = 0;
  std::size_t segments_ = 0;
  std::uint64_t started_ = 0;
  std::uint64_t stopped_ = 0;
  std::uint64_t transmitted_ = 0;
  std::vector<CompactBeam> beams_;
  std::size_t segments_of_turn_ = 0;  // as far as it is known
  int short_turns_ = 0;               // that had fewer, in a row

  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
};

}  // namespace rack::device

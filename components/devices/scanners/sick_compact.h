// SICK picoScan100 and multiScan100. They send scans by UDP (port 2115) in segments of a turn, one
// per datagram, in SICK's format "Compact".
//
//    0  02 02 02 02, type (u32; 1 segment, 2 inertial unit), counter (u64), time of sending (u64,
//    us),
//       version (u32; 3 or 4), size of the first module (u32)
//   32  modules, and CRC-32 of everything before (u32)
//
// A module has one or more layers with the same number of beams: segment and frame (turn) number
// (u64 each), serial number, layers, beams, echoes (u32 each); for each layer the times of its
// first and last beam (u64, us), its elevation, and the azimuths of both beams (f32, rad); the
// factor of distances (f32, version 4 only), size of the next module (u32; 0: last module), four
// bytes that state which values an echo and a beam have; and for each beam and each layer: distance
// and remission (u16 each) of every echo, a byte of flags and an azimuth (u16), in version 3 in
// reverse order. All little-endian; angles are counterclockwise from straight ahead.
//
// The scanner must be configured to send, and to which host: on its web page, or by CoLa A at TCP
// port 2111 with ScanDataEthSettings (1 for UDP, the four numbers of the address, the port),
// ScanDataFormat (2 for Compact) and ScanDataEnable. The driver only listens, so it does not
// disturb other receivers of the scanner.
//
// Sources: SICK's "Data format description Compact"; its ScanSegmentAPI and sick_scan_xd.
#pragma once

#include <vector>

#include "rack/devices/device_clock.h"
#include "rack/devices/dialogue.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

struct CompactBeam {
  float azimuth = 0;           // rad, counterclockwise
  std::uint32_t distance = 0;  // first echo, mm; 0: no echo
  std::uint16_t remission = 0;
  bool is_reflector = false;
};

// The layer with the smallest elevation of a segment.
struct CompactSegment {
  std::uint64_t counter = 0;
  std::uint64_t transmitted = 0;  // us
  std::uint64_t frame_number = 0;
  std::uint32_t serial_number = 0;
  std::uint64_t started = 0;  // us, times of the first and the last beam
  std::uint64_t stopped = 0;
  float elevation = 0;
  std::vector<CompactBeam> beams{};
};

std::uint32_t crc32(std::span<const std::byte> bytes);

enum class CompactKind : std::uint8_t { kBroken, kSegment, kOther };
// Does not allocate if the capacity of `segment` suffices.
CompactKind decode_compact(std::span<const std::byte> datagram, CompactSegment& segment);

struct SickCompactSettings {
  std::uint32_t serial_number = 0;  // required serial number; 0: any
  std::int32_t max_range = 75000;   // mm
};

// Only listens, so recordings need no special treatment.
class SickCompact final : public Dialogue {
 public:
  explicit SickCompact(const SickCompactSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  // True after the first turn, which is incomplete and therefore not used as a scan.
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(LadarData& scan, Time& recorded);

  // Serial number in the newest datagram.
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
  // Data received instead of scans, for the error message.
  std::uint64_t datagrams_ = 0;
  std::uint64_t broken_ = 0;
  std::uint64_t of_others_ = 0;

  // The turn that is being assembled.
  bool has_frame_ = false;
  bool is_finished_ = false;  // further segments of this turn are ignored
  std::uint64_t frame_number_ = 0;
  std::size_t segments_ = 0;
  std::uint64_t started_ = 0;
  std::uint64_t stopped_ = 0;
  std::uint64_t transmitted_ = 0;
  std::vector<CompactBeam> beams_;
  std::size_t segments_of_turn_ = 0;  // 0 if unknown
  int short_turns_ = 0;               // number of consecutive turns with fewer segments

  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
};

}  // namespace rack::device

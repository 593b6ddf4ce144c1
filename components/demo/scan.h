// The body of a laser scan as the original sends it (specification, section 9: ladar DATA).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tims::demo {

inline constexpr std::uint32_t kPoints = 361;
inline constexpr std::size_t kScanHead = 24;   // bytes
inline constexpr std::size_t kScanPoint = 16;  // bytes
inline constexpr std::size_t kScanBytes = kScanHead + kPoints * kScanPoint;

// A half circle of points, 0.5 degrees apart, in a round room whose wall breathes with `number`.
// `time_ms`: of the recording. Little endian.
void write_scan(std::uint32_t number, std::uint32_t time_ms, std::span<std::byte, kScanBytes> body);

struct ScanSummary {
  std::uint32_t time_ms = 0;
  std::uint32_t points = 0;
  std::int32_t nearest_mm = 0;
};
// False when the body is not a scan.
bool read_scan(std::span<const std::byte> body, ScanSummary& summary);

}  // namespace tims::demo

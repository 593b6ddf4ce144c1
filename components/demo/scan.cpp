#include "components/demo/scan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

namespace tims::demo {

namespace {

static_assert(std::endian::native == std::endian::little, "the demo writes native bodies");

constexpr std::uint32_t kScanTimeMs = 13;
constexpr std::int32_t kRangeMaxMm = 8191;

template <typename T>
void put(std::byte*& at, T value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

template <typename T>
T get(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

}  // namespace

void write_scan(std::uint32_t number, std::uint32_t time_ms,
                std::span<std::byte, kScanBytes> body) {
  constexpr float kHalf = std::numbers::pi_v<float> / 2;
  std::byte* at = body.data();
  put(at, time_ms);
  put(at, kScanTimeMs);
  put(at, kRangeMaxMm);
  put(at, -kHalf);
  put(at, kHalf);
  put(at, kPoints);
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const float angle = -kHalf + static_cast<float>(i) * (2 * kHalf / (kPoints - 1));
    const float wall = 3000 + 500 * std::sin(static_cast<float>(number) / 75 + 4 * angle);
    put(at, angle);
    put(at, static_cast<std::int32_t>(wall));
    put(at, std::int32_t{0});    // type
    put(at, std::int32_t{100});  // intensity
  }
}

bool read_scan(std::span<const std::byte> body, ScanSummary& summary) {
  if (body.size() < kScanHead) return false;
  summary.time_ms = get<std::uint32_t>(body.data());
  summary.points = get<std::uint32_t>(body.data() + 20);
  if (summary.points > (body.size() - kScanHead) / kScanPoint) return false;
  summary.nearest_mm = std::numeric_limits<std::int32_t>::max();
  for (std::uint32_t i = 0; i < summary.points; ++i) {
    const std::byte* point = body.data() + kScanHead + i * kScanPoint;
    summary.nearest_mm = std::min(summary.nearest_mm, get<std::int32_t>(point + 4));
  }
  return true;
}

}  // namespace tims::demo

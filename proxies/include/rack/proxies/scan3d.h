// A three-dimensional scan (specification, section 9.22).
#pragma once

#include <array>
#include <cstddef>

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct Scan3dType {
  enum : i8 {
    kGetRangeImage = 21,  // answered by kRangeImage
    kStoreData = 22,
    kRangeImage = -21,  // Scan3dRangeImageData
  };
};

namespace scan_mode {
inline constexpr i32 kRoll = 1;
inline constexpr i32 kPitch = 2;
inline constexpr i32 kYaw = 3;
inline constexpr i32 kTop = 4;
inline constexpr i32 kTopDown = 5;
inline constexpr i32 kPositiveTurn = 0x100;  // added to one of the above
inline constexpr i32 kSquareGrid = 0x200;
inline constexpr i32 kStartAt180 = 0x400;
}  // namespace scan_mode

// Original programs accept up to 72400 points, those built for the Kinect 307200.
inline constexpr std::size_t kScan3dPointsMax = 307200;

struct Scan3dData {
  TimeStamp recordingTime = 0;
  Milliseconds<u32> duration = 0;
  Millimetres<i32> maxRange = 0;
  i32 scanNum = 0;       // number of planar scans in it
  i32 scanPointNum = 0;  // points of each
  i32 scanMode = 0;      // a scan_mode
  i32 scanHardware = 0;
  i32 sectorNum = 1;
  i32 sectorIndex = 0;
  Position3d refPos = {};
  i32 pointNum = 0;
  i32 compressed = 0;  // 0: points follow; else the number of compressed bytes that follow
  Tail<ScanPoint, kScan3dPointsMax> points = {};
  Tail<std::byte, kScan3dPointsMax* 20> compressedPoints = {};  // specification, section 13

  static constexpr std::size_t kBodyMax = 68 + kScan3dPointsMax * 20;

  [[nodiscard]] std::array<std::int64_t, 2> tail_sizes() const {
    if (compressed != 0) return {0, compressed};
    return {pointNum, 0};
  }
};

struct RangePixel {
  Millimetres<i16> range = 0;
  i16 type = 0;
};

struct Scan3dRangeImageData {
  TimeStamp recordingTime = 0;
  i32 scanMode = 0;
  Millimetres<i32> maxRange = 0;
  i16 scanNum = 0;       // rows
  i16 scanPointNum = 0;  // pixels of each
  Tail<RangePixel, kScan3dPointsMax> points = {};

  static constexpr std::size_t kSurplus = 24;  // appended by Java programs

  [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const {
    if (scanNum < 0 || scanPointNum < 0) return {-1};
    return {std::int64_t{scanNum} * scanPointNum};
  }
};

class Scan3dProxy : public DataProxy<Scan3dData, tims::class_id::kScan3d> {
 public:
  using DataProxy::DataProxy;

  // The scanner may have to rotate first.
  Result<Scan3dRangeImageData> get_range_image(tims::Duration timeout = std::chrono::seconds(10)) {
    return query<Scan3dRangeImageData>(Scan3dType::kGetRangeImage, Scan3dType::kRangeImage,
                                       timeout);
  }
  Result<void> store_data(tims::Duration timeout = std::chrono::seconds(10)) {
    return command(Scan3dType::kStoreData, timeout);
  }
};

}  // namespace rack

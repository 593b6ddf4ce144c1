// Camera images (specification, section 9.1).
#pragma once

#include <array>
#include <cstddef>

#include "rack/proxies/proxy.h"

namespace rack {

struct CameraType {
  enum : i8 {
    kGetParameter = 21,  // answered by kParameter
    kSetFormat = 22,     // CameraFormatData
    kParameter = -21,    // CameraParamData
    kFormat = -22,       // CameraFormatData; no known program sends it
  };
};

namespace camera_mode {
inline constexpr u16 kMono8 = 1;
inline constexpr u16 kMono12 = 2;
inline constexpr u16 kMono16 = 3;
inline constexpr u16 kMono24 = 4;
inline constexpr u16 kRgb24 = 11;  // B G R, in spite of its name, as the original sends it
inline constexpr u16 kRgb565 = 12;
inline constexpr u16 kYuv422 = 21;  // U Y0 V Y1
inline constexpr u16 kRaw8 = 31;    // one colour per pixel: colorFilterId
inline constexpr u16 kRaw12 = 32;
inline constexpr u16 kRaw16 = 33;
inline constexpr u16 kJpeg = 41;
inline constexpr u16 kRange = 51;
inline constexpr u16 kIntensity = 52;
inline constexpr u16 kTypeIntensity = 53;
inline constexpr u16 kRangeType = 54;
inline constexpr u16 kSegment = 55;
inline constexpr u16 kElevation = 56;
inline constexpr u16 kType = 57;
inline constexpr u16 kEdge = 58;
inline constexpr u16 kDisparity = 59;
}  // namespace camera_mode

namespace bayer {
inline constexpr u32 kRggb = 512;
inline constexpr u32 kGbrg = 513;
inline constexpr u32 kGrbg = 514;
inline constexpr u32 kBggr = 515;
}  // namespace bayer

inline constexpr std::size_t kCameraBytesMax = 3932160;  // 1280 * 1024 pixels of 24 bits

struct CameraData {
  TimeStamp recordingTime = 0;
  Pixels<u16> width = 0;                       // originals: up to 1280
  Pixels<u16> height = 0;                      // originals: up to 1024
  Quantity<u16, unit::BitPerPixel> depth = 0;  // originals: up to 24
  u16 mode = 0;                                // a camera_mode
  // a bayer value; for kJpeg the number of bytes of the image
  u32 colorFilterId = 0;
  Tail<std::byte, kCameraBytesMax> image = {};  // 16-bit pixels are never byte-swapped

  [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const {
    if (mode == camera_mode::kJpeg) return {std::int64_t{colorFilterId}};
    return {std::int64_t{width} * height * depth / 8};
  }
};

struct CameraParamData {
  Pixels<i32> calibration_width = 0;
  Pixels<i32> calibration_height = 0;
  Millimetres<f32> f = 0;  // focal length
  Pixels<f32> fx = 0;
  Pixels<f32> fy = 0;
  f32 sx = 1;  // scale
  f32 sy = 1;
  Millimetres<f32> dx = 0;  // size of a sensor element
  Millimetres<f32> dy = 0;
  Quantity<f32, unit::PerMillimetre2> k1 = 0;  // radial distortion
  Quantity<f32, unit::PerMillimetre2> k2 = 0;
  Quantity<f32, unit::PerMillimetre> p1 = 0;  // tangential distortion
  Quantity<f32, unit::PerMillimetre> p2 = 0;
  Pixels<f32> e0 = 0;  // principal point
  Pixels<f32> n0 = 0;
  std::array<f32, 9> coordinateRotation = {};  // 3x3, row by row
  std::array<Millimetres<f32>, 3> coordinateTranslation = {};
};

struct CameraFormatData {
  Pixels<i32> width = 0;
  Pixels<i32> height = 0;
  Quantity<i32, unit::BitPerPixel> depth = 0;
  i32 mode = 0;  // a camera_mode
};

class CameraProxy : public DataProxy<CameraData, tims::class_id::kCamera> {
 public:
  using DataProxy::DataProxy;

  Result<CameraParamData> get_parameter() {
    return query<CameraParamData>(CameraType::kGetParameter, CameraType::kParameter);
  }
  Result<void> set_format(const CameraFormatData& format) {
    return command(CameraType::kSetFormat, format);
  }
};

}  // namespace rack

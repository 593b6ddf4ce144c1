// Monte Carlo localisation in a map (specification, section 9.15).
#pragma once

#include "rack/proxies/generic.h"
#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct MclType {
  enum : i8 {
    kLoadMap = 21,  // FileName
  };
};

struct MclDataPoint {
  Millimetres<i32> x = 0;
  Millimetres<i32> y = 0;
  Millimetres<i32> z = 0;  // 2D: the measured range
  i32 type = 0;            // a mcl_point value
  i32 layer = 0;
};

namespace mcl_point {
inline constexpr i32 kSample = 1;
inline constexpr i32 kMeasurement = 2;
inline constexpr i32 kReflector = 3;
inline constexpr i32 kLine = 10;
}  // namespace mcl_point

struct MclData {
  TimeStamp recordingTime = 0;
  Position3d pos = {};  // the estimate
  Count pointNum = {};
  Sequence<MclDataPoint, 1000> points = {};
};

class MclProxy : public DataProxy<MclData, tims::class_id::kMcl> {
 public:
  using DataProxy::DataProxy;

  Result<void> load_map(std::string_view file) {
    return command(MclType::kLoadMap, FileName::of(file), file_timeout());
  }
};

}  // namespace rack

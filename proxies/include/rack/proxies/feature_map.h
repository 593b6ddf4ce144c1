// A map of lines (specification, section 9.13).
#pragma once

#include "rack/proxies/generic.h"
#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct FeatureMapType {
  enum : i8 {
    kLoadMap = 21,  // FileName
    kAddLine = 22,  // FeatureMapFeature
    kSaveMap = 23,  // FileName
    kGiveMap = 24,
    kDeleteLine = 25,    // FeatureMapFeature
    kDisplaceLine = 26,  // FeatureMapFeature
    kGetLayer = 27,      // answered by kLayer
    kSetLayer = 28,      // FeatureMapLayerData
    kLayer = 19,         // FeatureMapLayerData; a reply, although replies are normally < 0
  };
};

struct FeatureMapDataPoint {
  Millimetres<f64> x = 0;  // start
  Millimetres<f64> y = 0;
  Millimetres<f64> x2 = 0;  // end
  Millimetres<f64> y2 = 0;
  Millimetres<f64> l = 0;  // length
  Radians<f64> rho = 0;    // direction
  f64 sin = 0;             // of rho
  f64 cos = 1;             // of rho
  i32 layer = 0;           // 0 to 19
  i32 type = kLine;

  static constexpr i32 kLine = 10;
};

struct FeatureMapData {
  TimeStamp recordingTime = 0;
  Position3d pos = {};  // of the robot
  Count featureNum = {};
  Sequence<FeatureMapDataPoint, 200> features = {};
};

struct FeatureMapFeature {
  TimeStamp recordingTime = 0;
  FeatureMapDataPoint feature = {};
  i32 featureNumTemp = 0;
};

struct FeatureMapLayerData {
  Count layerNum = {};
  Sequence<i32, 20> layers = {};

  static constexpr std::size_t kWholeSize = 4 + 20 * 4;  // the C structure
};

class FeatureMapProxy : public DataProxy<FeatureMapData, tims::class_id::kFeatureMap> {
 public:
  using DataProxy::DataProxy;

  Result<void> load_map(std::string_view file) {
    return command(FeatureMapType::kLoadMap, FileName::of(file), file_timeout());
  }
  Result<void> save_map(std::string_view file) {
    return command(FeatureMapType::kSaveMap, FileName::of(file), file_timeout());
  }
  Result<void> add_line(const FeatureMapFeature& line) {
    return command(FeatureMapType::kAddLine, line);
  }
  Result<void> delete_line(const FeatureMapFeature& line) {
    return command(FeatureMapType::kDeleteLine, line);
  }
  Result<void> displace_line(const FeatureMapFeature& line) {
    return command(FeatureMapType::kDisplaceLine, line);
  }
  Result<FeatureMapLayerData> get_layer() {
    return query<FeatureMapLayerData>(FeatureMapType::kGetLayer, FeatureMapType::kLayer);
  }
  Result<void> set_layer(const FeatureMapLayerData& layers) {
    return command(FeatureMapType::kSetLayer, layers);
  }
};

}  // namespace rack

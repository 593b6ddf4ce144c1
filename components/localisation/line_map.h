// A map made of lines that people edit: read from a floor plan, changed line by line, and written
// as one again. Pure.
//
// A data set has room for 200 lines. Of larger maps it holds those nearest to the robot. Who edits
// names a line by its place in the newest data set, so that which line stood where is kept until
// the next one is made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
#include "rack/proxies/feature_map.h"
#include "tims/result.h"

namespace rack::localisation {

// Between the units of a plan and the frame of RACK: x = (its y - offset_x) * scale.
struct PlanScale {
  double scale = 1000;  // mm for each of its units
  double offset_x = 0;
  double offset_y = 0;
};

class LineMap {
 public:
  static constexpr std::size_t kLinesMax = DxfDrawing::kLinesMax;
  static constexpr i32 kLayers = 20;

  LineMap();
  LineMap(const DxfDrawing& drawing, const PlanScale& scale);

  // DXF (R12), lines only, each in the layer that is called by its number.
  [[nodiscard]] std::string to_dxf(const PlanScale& scale) const;

  [[nodiscard]] std::size_t size() const { return lines_.size(); }
  // kInvalidArgument: no line, a layer that is none, no room.
  tims::Result<void> add(const FeatureMapDataPoint& line);
  // `place`: in the newest data set; kInvalidArgument: it has none there.
  tims::Result<void> erase(i32 place);
  tims::Result<void> displace(i32 place, const FeatureMapDataPoint& to);

  // Which layers data sets show; at first all.
  [[nodiscard]] FeatureMapLayerData layers() const;
  void show(const FeatureMapLayerData& layers);

  // The lines that are shown, those nearest to `robot` first when there are too many.
  void fill(const Pose& robot, FeatureMapData& data);

 private:
  [[nodiscard]] bool shown(const FeatureMapDataPoint& line) const;
  [[nodiscard]] tims::Result<std::size_t> at(i32 place) const;

  std::vector<FeatureMapDataPoint> lines_;
  std::vector<bool> layers_;
  std::vector<std::size_t> order_;  // lines of the newest data set
};

}  // namespace rack::localisation

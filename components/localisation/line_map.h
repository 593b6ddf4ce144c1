// A map of lines that users edit: read from a floor plan, changed line by line, and written as a
// floor plan. Pure.
//
// A data set has room for 200 lines; from a larger map it holds those nearest to the robot. An
// editor refers to a line by its index in the newest data set, so the assignment of indices to
// lines is kept until the next data set is made.
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

class LineMap {
 public:
  static constexpr std::size_t kLinesMax = DxfDrawing::kLinesMax;
  static constexpr i32 kLayers = 20;

  LineMap();
  explicit LineMap(const DxfPlan& plan);

  // DXF (R12) with lines only, and its unit; the name of each layer is its number.
  [[nodiscard]] std::string to_dxf(const PlanPlacement& placement) const;

  [[nodiscard]] std::size_t size() const { return lines_.size(); }
  // Lines of the plan that are too far away.
  [[nodiscard]] std::size_t left_out() const { return left_out_; }
  // kInvalidArgument: not a line, layer out of range, or the map is full.
  tims::Result<void> add(const FeatureMapDataPoint& line);
  // `place`: index in the newest data set; kInvalidArgument: there is no such line.
  tims::Result<void> erase(i32 place);
  tims::Result<void> displace(i32 place, const FeatureMapDataPoint& to);

  // The layers that data sets contain; initially all.
  [[nodiscard]] FeatureMapLayerData layers() const;
  void show(const FeatureMapLayerData& layers);

  // The lines of the shown layers; when they are too many, those nearest to `robot`.
  void fill(const Pose& robot, FeatureMapData& data);

 private:
  [[nodiscard]] bool shown(const FeatureMapDataPoint& line) const;
  [[nodiscard]] tims::Result<std::size_t> at(i32 place) const;

  std::vector<FeatureMapDataPoint> lines_;
  std::size_t left_out_ = 0;
  std::vector<bool> layers_;
  std::vector<std::size_t> order_;  // index in lines_ of each line of the newest data set
};

}  // namespace rack::localisation

// Drawings in DXF: the lines of a floor plan. Pure.
//
// dxflib reads the entities, their attributes and the tables; what it does not check before it uses
// it, dxf_entity.h does. Read are LINE, POINT, POLYLINE, LWPOLYLINE, ARC, CIRCLE, ELLIPSE, and
// INSERT of a block with its scale, rotation, rows and columns, also nested. Curves and bulges
// become chords of at most 5 degrees, so that a chord is off by a thousandth of the radius at most.
// Left out are the paper space, invisible entities, layers that are off or frozen or not chosen,
// and types that are not read. All that is left out is reported: damaged entities and those of
// types that may be walls with their line number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack {

struct DxfPoint {
  double x = 0;  // to the east, in units of the drawing
  double y = 0;  // to the north
};

struct DxfLine {
  DxfPoint from;
  DxfPoint to;
  std::int32_t layer = 0;  // number in its name
};

struct DxfDrawing {
  std::vector<DxfLine> lines;
  std::vector<std::string> remarks;  // "line 17: LINE without an end", at most kRemarksMax
  std::size_t others = 0;            // entities of other types, invisible, or in the paper space
  double unit = 0;                   // mm, from $INSUNITS; 0: not stated

  static constexpr std::size_t kLinesMax = 20000;
  static constexpr std::size_t kRemarksMax = 20;
  static constexpr double kFarthest = 1e9;  // limit of a plausible coordinate

  // The mm per unit to use: `wanted`, or for 0 what the drawing states (kInvalidArgument: nothing).
  // When both are known and differ, a remark is added.
  tims::Result<double> scale(double wanted);
};

// The error kMalformed names the line where the text is not DXF. `layers`: see PlanPlacement.
tims::Result<DxfDrawing> read_dxf(std::string_view text, std::string_view layers = {});

// Conversion of a floor plan to the frame of RACK: x = (plan y - offset_x) * scale, y = (plan x -
// offset_y) * scale.
struct PlanPlacement {
  double scale = 1000;         // mm per unit of the plan; 0: as the plan states
  double scale_otherwise = 0;  // for scale 0, when the plan states none; 0: that is an error
  double offset_x = 0;
  double offset_y = 0;
  // The layers whose lines are walls, by names with * and ?, separated by commas: "walls,
  // pillars*". With a minus those that are not: "-exits". Empty: all.
  std::string layers{};
};

// A floor plan: a drawing whose place is known.
struct DxfPlan {
  DxfDrawing drawing{};
  PlanPlacement placement{};  // with the scale that is used
};

// read_dxf() and DxfDrawing::scale(). A drawing of which all is left out is an error. Errors and
// remarks name the file: "floor.dxf: not DXF", "floor.dxf, line 17: LINE without an end".
tims::Result<DxfPlan> read_plan(std::string_view name, std::string_view text,
                                const PlanPlacement& wanted);

}  // namespace rack

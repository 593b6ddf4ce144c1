// Lines of a drawing in DXF, as text (specification, section 10.3). Pure; reads what anybody wrote.
//
// A DXF file is pairs of lines: a group code, and a value. Taken are LINE, POLYLINE with its
// VERTEXes, LWPOLYLINE and POINT of the section ENTITIES (or of no section at all); curves in
// polylines become straight. Everything else is left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack {

struct DxfPoint {
  double x = 0;  // as in the drawing: to the east
  double y = 0;  // to the north
};

struct DxfLine {
  DxfPoint from;
  DxfPoint to;
  std::int32_t layer = 0;  // its name as a number
};

struct DxfDrawing {
  std::vector<DxfLine> lines;
  std::vector<std::string> skipped;  // "line 17: LINE without an end", at most kSkippedMax
  std::size_t others = 0;            // entities of other types

  static constexpr std::size_t kLinesMax = 20000;
  static constexpr std::size_t kSkippedMax = 20;
};

// kMalformed says in which line this stops being DXF.
tims::Result<DxfDrawing> read_dxf(std::string_view text);

}  // namespace rack

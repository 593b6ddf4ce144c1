// Any text is refused with a line number, or yields a bounded number of lines with finite ends, and
// a map that can be queried.
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using tims::fuzz::require;
  tims::fuzz::Input input(data, size);
  const std::string_view text = input.text();
  // The choice of layers is the first line of some inputs.
  const bool has_choice = text.starts_with("layers ");
  const auto cut = has_choice ? std::min(text.find('\n'), text.size()) : 0;
  const auto drawing =
      rack::read_dxf(text.substr(cut), has_choice ? text.substr(7, cut - 7) : std::string_view());
  if (!drawing) {
    require(!drawing.error().detail().empty());
    return 0;
  }
  require(drawing->lines.size() <= rack::DxfDrawing::kLinesMax);
  require(drawing->remarks.size() <= rack::DxfDrawing::kRemarksMax);
  for (const auto& line : drawing->lines) {
    require(std::isfinite(line.from.x) && std::isfinite(line.from.y));
    require(std::isfinite(line.to.x) && std::isfinite(line.to.y));
  }
  std::array<double, 37> ranges{};
  rack::FloorMap(*drawing, 1000, 0, 0).cast({{}, -rack::kPi, rack::radians(10)}, 10000, ranges);
  for (const double range : ranges) require(range >= 0 && range <= 10000);
  return 0;
}

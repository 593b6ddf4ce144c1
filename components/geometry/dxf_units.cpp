#include "components/geometry/dxf_units.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>

#include "components/geometry/dxf.h"

namespace rack {

namespace {

// What floors are drawn in.
struct Unit {
  int code;
  double mm;
};
constexpr std::array<Unit, 14> kUnits = {Unit{1, 25.4},    Unit{2, 304.8},
                                         Unit{3, 1609344}, Unit{4, 1},
                                         Unit{5, 10},      Unit{6, 1000},
                                         Unit{7, 1e6},     Unit{9, 0.0254},
                                         Unit{10, 914.4},  Unit{13, 0.001},
                                         Unit{14, 100},    Unit{15, 1e4},
                                         Unit{16, 1e5},    Unit{21, 1200000.0 / 3937}};

constexpr double kSameUnit = 1e-3;  // the scale is a parameter with whole numbers

bool is_same(double unit, double mm) { return std::abs(unit - mm) <= kSameUnit * unit; }

}  // namespace

double dxf_unit_length(int code) {
  const auto* const unit = std::ranges::find(kUnits, code, &Unit::code);
  return unit != kUnits.end() ? unit->mm : 0;
}

int dxf_unit(double mm) {
  const auto* const unit =
      std::ranges::find_if(kUnits, [&](const Unit& known) { return is_same(known.mm, mm); });
  return unit != kUnits.end() ? unit->code : 0;
}

tims::Result<double> DxfDrawing::scale(double wanted) {
  if (wanted == 0) {
    if (unit > 0) return unit;
    return tims::Error(tims::Errc::kInvalidArgument,
                       "the drawing does not state its unit ($INSUNITS): set the scale, in mm per "
                       "unit");
  }
  if (unit > 0 && !is_same(unit, wanted))
    remarks.insert(
        remarks.begin(),
        fmt::format("its unit is {} mm by $INSUNITS, but it is read with {} mm per unit; "
                    "with 0, its own unit is used",
                    unit, wanted));
  return wanted;
}

}  // namespace rack

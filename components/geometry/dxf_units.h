// The units of drawings: the variable $INSUNITS.
#pragma once

namespace rack {

// The length in mm; 0: not stated, or nothing that floors are drawn in.
double dxf_unit_length(int code);
// The code for a unit of this length; 0: there is none.
int dxf_unit(double mm);

}  // namespace rack

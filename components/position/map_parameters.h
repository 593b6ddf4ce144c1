// The parameters of components that read a map from a file: the same names, ranges and help in all.
#pragma once

#include "components/geometry/dxf.h"
#include "rack/parameters.h"

namespace rack::navigation {

inline constexpr ParameterInfo kMapScaleFactor = {
    "mapScaleFactor", 1000, "size of a unit of a floor plan [mm]; 0: as the plan states", 0, 1e6};
inline constexpr ParameterInfo kMapOffsetX = {
    "mapOffsetX", 0, "north of the floor plan that is x = 0, in its units"};
inline constexpr ParameterInfo kMapOffsetY = {"mapOffsetY", 0,
                                              "east of the floor plan that is y = 0, in its units"};
inline constexpr ParameterInfo kMapLayers = {"mapLayers", "",
                                             "layers of a floor plan that are walls, such as "
                                             "\"walls*, pillars\"; \"-exits\": all but these; "
                                             "empty: all"};
inline constexpr ParameterInfo kMapResolution = {"mapResolution", 50,
                                                 "cell size for floor plans [mm]", 1, 1000};

}  // namespace rack::navigation

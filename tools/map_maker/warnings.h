// What the user of a map must know about its errors, as text. Pure.
#pragma once

#include <string>
#include <vector>

#include "components/mapping/map_maker.h"

namespace rack::map_maker {

// Scans see through walls of the map along more than 2 % of what was driven more than once.
bool contradicts_itself(const mapping::MadeMap& made);

// Empty for a map that can be used. `picture`: file with the walls that contradict the map.
//
// Each warning covers errors that the others miss: in a map that is bent evenly no wall is drawn
// twice, but its poses are uncertain; a wrong loop makes poses certain that are wrong, but others
// contradict it, or walls are drawn over each other.
std::vector<std::string> warnings(const mapping::MadeMap& made,
                                  const mapping::MapSettings& settings, const std::string& picture);

}  // namespace rack::map_maker

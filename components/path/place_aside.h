// Where a vehicle makes room for somebody who comes towards it. Pure.
//
// A vehicle and a person who meet in a door wait for each other for ever. One of them has to go
// back to where the other one can pass. A person who comes out of the door walks along the path of
// the vehicle, or along its trail, so the place has to be beside both: the nearest one that the
// vehicle can reach, where it can turn, at the largest of several distances from the lane.
#pragma once

#include <optional>
#include <span>

#include "components/path/grid_search.h"

namespace rack::path {

struct AsideSettings {
  double room_to_pass = 0;  // clearance that the vehicle needs to drive, mm
  double room_to_turn = 0;  // clearance that it needs at the place
  double half_width = 0;    // of the vehicle
};

// The farthest that a vehicle goes, mm.
inline constexpr double kAsideMost = 10000;

// `space`: with the obstacles that were seen; `lane`: places of the path and the trail. Nothing:
// no place beside the lane can be reached.
std::optional<Place> place_aside(const FreeSpace& space, GridSearch& cells,
                                 const AsideSettings& settings, const Place& from,
                                 std::span<const Place> lane);

}  // namespace rack::path

// People and other things that move. Pure.
//
// A person who walks ahead of the robot along a bare corridor is the only thing that seems to tell
// where along it the robot is. What stands still is seen at the same place by the scans shortly
// before and after; what these scans see through has moved.
#pragma once

#include "components/mapping/keyframes.h"

namespace rack::mapping {

// Points that have moved are no longer on a wall. Returns their number.
std::size_t forget_moving(Track& track);

}  // namespace rack::mapping

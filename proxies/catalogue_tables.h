// The parts that the catalogue is made of: one source each, so that they compile side by side.
#pragma once

#include <span>

#include "rack/proxies/catalogue.h"

namespace rack {

std::span<const MessageInfo> driver_messages();      // sensors and actuators
std::span<const MessageInfo> perception_messages();  // maps, scans, objects
std::span<const MessageInfo> navigation_messages();  // position, path, pilot; datalog, planner

}  // namespace rack

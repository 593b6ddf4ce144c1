// Names of classes of components that are none of RACK's, for all that is read and written as text:
// "Thermometer(0/0)" instead of "unknown[80](0/0)".
#pragma once

#include <cstdint>
#include <string_view>

#include "tims/export.h"

namespace tims {

// From now on in this program. Before it has threads; `name` must stay. False: the number or the
// name is another class's, or there are 64 already.
TIMS_API bool name_class(std::uint32_t class_id, std::string_view name);

}  // namespace tims

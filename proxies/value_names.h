// Names of the numbers of messages that stand for something: modes, kinds, flags. The C++ constants
// have no names at run time, so each list is written here once more, with the constants themselves.
#pragma once

#include <span>
#include <string_view>

#include "rack/codec/quantity.h"

namespace rack {

struct ValueName {
  std::string_view name;
  i64 value;
};

struct FieldValues {
  std::string_view field;             // "CameraData.mode"
  std::span<const ValueName> values;  // what is left without the flags
  std::span<const ValueName> flags{};
};

std::span<const FieldValues> field_values();

}  // namespace rack

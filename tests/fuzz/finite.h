// Checks that no number of a message is infinite or NaN; no field of any class permits that.
#pragma once

#include <cmath>

#include "rack/codec/fields.h"
#include "tests/fuzz/fuzz_input.h"

namespace tims::fuzz {

template <typename T>
void require_finite(const T& value) {
  if constexpr (std::floating_point<T>) {
    require(std::isfinite(value));
  } else if constexpr (rack::WrappedNumber<T>) {
    require_finite(value.raw());
  } else if constexpr (rack::kIsVariable<T> || rack::kIsArray<T>) {
    for (const auto& element : value) require_finite(element);
  } else if constexpr (rack::Struct<T> && !rack::Number<T> && !rack::kIsText<T>) {
    rack::reflect::all_fields(value, [](const auto& field, auto) {
      require_finite(field);
      return true;
    });
  }
}

}  // namespace tims::fuzz

// How a row of the table of options reaches its member of Config.
#pragma once

#include <cstdint>

#include "router/config/options.h"

namespace tims::config {

inline constexpr std::int64_t kKi = 1LL << 10;
inline constexpr std::int64_t kGi = 1LL << 30;
inline constexpr std::int64_t kMs = 1'000'000;
inline constexpr std::int64_t kHour = 3'600'000 * kMs;

// How a member of Config is kept in a Value, and back.
template <Kind kind, typename T>
Value to_value(const T& member) {
  if constexpr (kind == Kind::kSize) return Bytes{std::int64_t{member}};
  if constexpr (kind == Kind::kRate) return Rate{static_cast<std::int64_t>(member)};
  if constexpr (kind == Kind::kNumber) return std::int64_t{member};
  return member;
}

template <Kind kind, typename T>
void from_value(T& member, const Value& value) {
  if constexpr (kind == Kind::kSize)
    member = static_cast<T>(std::get<Bytes>(value).count);
  else if constexpr (kind == Kind::kRate)
    member = static_cast<T>(std::get<Rate>(value).bytes_per_second);
  else if constexpr (kind == Kind::kNumber)
    member = static_cast<T>(std::get<std::int64_t>(value));
  else
    member = std::get<T>(value);
}

inline bool always(const Config& /*config*/, std::size_t /*index*/) { return true; }

// The struct that holds the member: a table of Config, or one item of a list of Config.
template <auto holder, typename AnyConfig>
auto& held(AnyConfig& config, [[maybe_unused]] std::size_t index) {
  if constexpr (requires { (config.*holder).at(index); })
    return (config.*holder).at(index);
  else
    return config.*holder;
}

// A row: the way to the value, then what is said about it.
template <Kind kind, auto holder, auto member>
constexpr Option row(Spec spec) {
  spec.kind = kind;
  return {spec,
          [](const Config& c, std::size_t i) { return to_value<kind>(held<holder>(c, i).*member); },
          [](Config& c, std::size_t i, const Value& value) {
            from_value<kind>(held<holder>(c, i).*member, value);
          },
          always};
}

}  // namespace tims::config

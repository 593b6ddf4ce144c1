// Parameters of a component: declared once, given as arguments when it starts, read and changed by
// messages while it runs (specification, section 5.4). Pure.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rack/proxies/generic.h"
#include "tims/address.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

using ParameterValue = std::variant<std::int32_t, std::string, float>;  // as Parameter::type counts

// Of a system or an instance, as far as parameters go; what fits into the addresses of a fleet is
// known with its router (Parameters::set_widths).
inline constexpr double kIdMax = 65535;

// What a component says about one of its parameters.
struct ParameterInfo {
  std::string_view name;
  std::variant<std::int32_t, std::string_view, float> initial;  // its type is the parameter's
  std::string_view help;                                        // one line, with the unit
  double min = -2147483648.0;                                   // of numbers
  double max = 2147483647.0;
  bool required = false;  // as an argument
  // When a new value does. What module_on() reads, and nothing later, is of the next ON.
  TakesEffect takes_effect = TakesEffect::kAtOn;
};

constexpr ParameterInfo at_once(ParameterInfo info) {
  info.takes_effect = TakesEffect::kNow;
  return info;
}
constexpr ParameterInfo at_start(ParameterInfo info) {
  info.takes_effect = TakesEffect::kAtStart;
  return info;
}

// One list behind another.
template <std::size_t N, std::size_t M>
constexpr std::array<ParameterInfo, N + M> joined(const std::array<ParameterInfo, N>& first,
                                                  const std::array<ParameterInfo, M>& second) {
  std::array<ParameterInfo, N + M> all{};
  std::ranges::copy(second, std::ranges::copy(first, all.begin()).out);
  return all;
}

// Those that every module has, before its own. They take effect where the runtime reads them.
std::span<const ParameterInfo> common_parameters();

class Parameters {
 public:
  // `program` is what the first record of the list says. The infos must outlive this. One of `own`
  // with a common name takes its place: another default.
  Parameters(std::string_view program, std::span<const ParameterInfo> own);

  [[nodiscard]] const std::string& program() const { return program_; }

  // Of a declared name and type.
  [[nodiscard]] std::int32_t integer(std::string_view name) const;
  [[nodiscard]] float real(std::string_view name) const;
  [[nodiscard]] const std::string& text(std::string_view name) const;

  // kInvalidArgument says which parameter, what it was to become, and what it may be; the old value
  // stays. An unknown name is suggested a known one.
  tims::Result<void> set(std::string_view name, std::string_view value);
  // False: there is no such parameter. Programs of the original may send any number type for any.
  tims::Result<bool> set(const Parameter& record);

  // Ids must fit into the fleet's addresses: "system", "instance", and those that end in "Sys" or
  // "Inst". kInvalidArgument: one that was given does not.
  tims::Result<void> set_widths(const tims::AddressWidths& widths);

  // As an argument would have it.
  [[nodiscard]] std::string as_text(std::string_view name) const;
  [[nodiscard]] ParameterList list() const;
  [[nodiscard]] ParameterEffects effects() const;  // in the order of list()

  struct Entry {
    const ParameterInfo* info;
    ParameterValue value;
    TakesEffect takes_effect = info->takes_effect;
    bool given = false;
    double max = info->max;
  };
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }

 private:
  [[nodiscard]] const Entry& entry(std::string_view name) const;
  Entry* find(std::string_view name);
  static tims::Result<void> assign(Entry& entry, ParameterValue value);

  std::string program_;
  std::vector<Entry> entries_;
};

// For people: "700", "none", "required".
std::string default_of(const ParameterInfo& info);
// What is allowed: "0 to 255", "at least 1", "any number", "a text".
std::string allowed(const ParameterInfo& info);

}  // namespace rack

#pragma GCC visibility pop

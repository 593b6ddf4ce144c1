// Parameters of a component: declared once, set by arguments at the start, read and changed by
// messages at run time (specification, section 5.4). Pure.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
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

using ParameterValue = std::variant<std::int32_t, std::string, float>;  // index is Parameter::type

// The maximum of a system or instance id as a parameter; the limit of the fleet's addresses is
// known after connecting to the router (Parameters::set_widths).
inline constexpr double kIdMax = 65535;

// The declaration of a parameter.
struct ParameterInfo {
  std::string_view name;
  std::variant<std::int32_t, std::string_view, float> initial;  // its type is the parameter's
  std::string_view help;       // one line, with the unit in brackets: "period of the data [ms]"
  double min = -2147483648.0;  // for numbers
  double max = 2147483647.0;
  bool required = false;  // must be given as an argument
  // When a new value takes effect. kAtOn: it is read by module_on() only.
  TakesEffect takes_effect = TakesEffect::kAtOn;
  // For the row of a partner only, see partner().
  std::string_view system_help{};
  // A file, folder or device of this host, see host_file().
  bool is_host_file = false;
  std::string_view choices{};  // see one_of()

  // "ms"; empty: none.
  [[nodiscard]] constexpr std::string_view unit() const {
    const std::size_t begin = help.find('[');
    const std::size_t end = std::min(help.find(']', begin), help.size());
    return begin < end ? help.substr(begin + 1, end - begin - 1) : std::string_view();
  }
};

constexpr ParameterInfo at_once(ParameterInfo info) {
  info.takes_effect = TakesEffect::kNow;
  return info;
}
constexpr ParameterInfo at_start(ParameterInfo info) {
  info.takes_effect = TakesEffect::kAtStart;
  return info;
}

// The values that have a meaning, each with it: "0 RMC, 1 GGA"; of texts "mono8, rgb24".
constexpr ParameterInfo one_of(std::string_view choices, ParameterInfo info) {
  info.choices = choices;
  return info;
}

// The parameter names a file, folder or device of this host, which the component then reads or
// writes. Only programs of this host may change it (tims/origin.h): others could otherwise make the
// component read or overwrite any file of its user.
constexpr ParameterInfo host_file(ParameterInfo info) {
  info.is_host_file = true;
  return info;
}

// --- partners: the other components that a component needs (rack/partner.h)

// One row declares two parameters: partner("ladar", "the ladar") declares ladarSys, "system id of
// the ladar", and ladarInst, "instance of the ladar". `instance` replaces the text after
// "instance of". A * in the name stands for Sys and Inst, which otherwise follow it.
constexpr ParameterInfo partner(std::string_view name, std::string_view what,
                                std::string_view instance = {}) {
  return {.name = name,
          .initial = 0,
          .help = instance.empty() ? what : instance,
          .min = 0,
          .max = kIdMax,
          .system_help = what};
}
// The instance must be given as an argument.
constexpr ParameterInfo required_partner(std::string_view name, std::string_view what,
                                         std::string_view instance = {}) {
  ParameterInfo row = partner(name, what, instance);
  row.required = true;
  return row;
}
// The instance may be -1: the component works without this partner.
constexpr ParameterInfo or_none(ParameterInfo row) {
  row.min = -1;
  return row;
}
// Without this partner by default.
constexpr ParameterInfo optional_partner(std::string_view name, std::string_view what,
                                         std::string_view instance) {
  ParameterInfo row = or_none(partner(name, what, instance));
  row.initial = -1;
  return row;
}
// The name of a partner's parameter; which: "Sys" or "Inst".
std::string partner_parameter(std::string_view partner, std::string_view which);

// --- lists of parameters

// Concatenates two lists.
template <std::size_t N, std::size_t M>
constexpr std::array<ParameterInfo, N + M> joined(const std::array<ParameterInfo, N>& first,
                                                  const std::array<ParameterInfo, M>& second) {
  std::array<ParameterInfo, N + M> all{};
  std::ranges::copy(second, std::ranges::copy(first, all.begin()).out);
  return all;
}

// The parameters that every module has, listed before its own.
std::span<const ParameterInfo> common_parameters();

class Parameters {
 public:
  // `program` is the first record of the list. The infos must outlive this. An entry of `own` with
  // the name of a common parameter replaces it, to change its default.
  Parameters(std::string_view program, std::span<const ParameterInfo> own);
  Parameters(const Parameters&) = delete;  // entries refer to members
  Parameters& operator=(const Parameters&) = delete;

  [[nodiscard]] const std::string& program() const { return program_; }

  // For declared names and their type.
  [[nodiscard]] std::int32_t integer(std::string_view name) const;
  [[nodiscard]] float real(std::string_view name) const;
  [[nodiscard]] const std::string& text(std::string_view name) const;

  // Error kInvalidArgument: names the parameter, the value and the allowed range; the old value
  // stays. For an unknown name, a similar one is suggested.
  tims::Result<void> set(std::string_view name, std::string_view value);
  // False: there is no such parameter. Programs of the original may send any number type for any
  // parameter. A text that is unchanged, also one that list() has cut, keeps its whole value: a
  // graphical interface sends back all parameters when one of them is changed. `is_foreign`: the
  // record comes from another host or over TCP; it cannot change a host_file().
  tims::Result<bool> set(const Parameter& record, bool is_foreign = false);

  // Ids must fit into the fleet's addresses: "system", "instance", and names that end in "Sys" or
  // "Inst". kInvalidArgument: one of the values given does not fit.
  tims::Result<void> set_widths(const tims::AddressWidths& widths);

  // In the form of a command line argument.
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
  void add(const ParameterInfo& info);
  void add_partner(const ParameterInfo& row);
  [[nodiscard]] const Entry& entry(std::string_view name) const;
  Entry* find(std::string_view name);
  static tims::Result<void> assign(Entry& entry, ParameterValue value);

  std::string program_;
  std::vector<Entry> entries_;
  std::deque<ParameterInfo> partners_;  // the parameters that the rows of partners declare
  std::deque<std::string> texts_;       // their names and help texts
};

// The help text without the unit: "period of the data".
std::string help_without_unit(const ParameterInfo& info);
// As text: "700", "none", "required".
std::string default_of(const ParameterInfo& info);
// The allowed values as text: "0 to 255", "at least 1", "any number", "a text".
std::string allowed(const ParameterInfo& info);

}  // namespace rack

#pragma GCC visibility pop

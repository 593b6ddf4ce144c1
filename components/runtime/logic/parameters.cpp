#include "rack/parameters.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <concepts>

#include "base/text.h"

namespace rack {
namespace {

// Long enough for any path; a message has room for 79 bytes and contains the beginning of a longer
// text.
constexpr std::size_t kTextMax = 4095;
constexpr double kLowest = -2147483648.0;
constexpr double kHighest = 2147483647.0;

// Order and names as every module of the original has them.
constexpr std::array<ParameterInfo, 8> kCommon = {
    at_start({"system", 0, "system id", 0, kIdMax}),
    at_start({"instance", 0, "instance id", 0, kIdMax}),
    at_once(one_of("0 print, 1 error, 2 warning, 3 info, 4 detail",
                   {"gdosLevel", 2, "level of log texts", 0, 4})),
    at_start({"targetStatus", 0, "1: turn on at start", 0, 1}),
    at_start({"cmdTaskPrio", 1, "real-time priority of the command task; 1: none", 0, 99}),
    at_start({"dataTaskPrio", 1, "real-time priority of the data task and of its messages; 1: none",
              0, 99}),
    at_start({"cpu", -1, "CPU of tasks with a real-time priority; -1: any", -1, 1023}),
    at_start({"errorTimeout", -1,
              "delay of the retry after an error [ms]; at least 10; -1: random, 2 to 4 s", -1}),
};

std::string plain(std::int32_t value) { return std::to_string(value); }
template <std::floating_point Number>
std::string plain(Number value) {
  std::array<char, 400> text{};  // the largest double has 309 digits
  const auto format = std::chars_format::fixed;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, format).ptr};
}

std::string to_text(const ParameterValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* whole = std::get_if<std::int32_t>(&value)) return plain(*whole);
  return plain(std::get<float>(value));
}

tims::Error refused(const Parameters::Entry& entry, std::string_view value) {
  ParameterInfo info = *entry.info;
  info.max = entry.max;
  return {tims::Errc::kInvalidArgument,
          std::string(info.name) + " = " + std::string(value) + ": must be " + allowed(info)};
}

// The number of bits that an id has in an address; 0: the parameter is not an id.
int bits_of_id(std::string_view name, const tims::AddressWidths& widths) {
  if (name == "system" || name.ends_with("Sys")) return widths.system;
  if (name == "instance" || name.ends_with("Inst")) return widths.instance;
  return 0;
}

ParameterValue initial_of(const ParameterInfo& info) {
  if (const auto* text = std::get_if<std::string_view>(&info.initial)) return std::string(*text);
  if (const auto* whole = std::get_if<std::int32_t>(&info.initial)) return *whole;
  return std::get<float>(info.initial);
}

// Whether the record has the text of the parameter, as list() reports it.
bool is_unchanged(const Parameter& record, const Parameters::Entry& entry) {
  const auto* text = std::get_if<std::string>(&entry.value);
  if (text == nullptr || record.type != Parameter::kString) return false;
  Parameter reported;
  (void)reported.valueString.assign(*text);
  return reported.valueString.view() == record.valueString.view();
}

// The number in a record, independent of its type: Java programs send the type that their table
// has.
std::optional<ParameterValue> value_of(const Parameter& record, const ParameterValue& like) {
  const bool text = std::holds_alternative<std::string>(like);
  if (text != (record.type == Parameter::kString)) return std::nullopt;
  if (text) return std::string(record.valueString.view());
  const bool real = record.type == Parameter::kFloat;
  if (!real && record.type != Parameter::kInt) return std::nullopt;
  if (std::holds_alternative<float>(like))
    return real ? record.valueFloat : static_cast<float>(record.valueInt);
  if (!real) return record.valueInt;
  const double value = std::round(static_cast<double>(record.valueFloat));
  if (!(value >= kLowest && value <= kHighest)) return std::nullopt;
  return static_cast<std::int32_t>(value);
}

}  // namespace

std::span<const ParameterInfo> common_parameters() { return kCommon; }

std::string help_without_unit(const ParameterInfo& info) {
  std::string help(info.help);
  if (info.unit().empty()) return help;
  const std::size_t begin = help.find('[');
  const std::size_t before = begin > 0 ? begin - 1 : begin;  // the blank
  return help.erase(before, help.find(']') + 1 - before);
}

std::string default_of(const ParameterInfo& info) {
  if (info.required) return "required";
  std::string text = to_text(initial_of(info));
  return text.empty() ? "none" : text;
}

std::string allowed(const ParameterInfo& info) {
  if (std::holds_alternative<std::string_view>(info.initial))
    return "a text of at most " + std::to_string(kTextMax) + " bytes" +
           (info.is_host_file ? ", changed by programs of this host only" : "");
  const std::string kind =
      std::holds_alternative<std::int32_t>(info.initial) ? "a whole number" : "a number";
  const bool low = info.min > kLowest;
  const bool high = info.max < kHighest;
  if (low && high) return kind + " from " + plain(info.min) + " to " + plain(info.max);
  if (low) return kind + ", at least " + plain(info.min);
  if (high) return kind + ", at most " + plain(info.max);
  return kind;
}

std::string partner_parameter(std::string_view partner, std::string_view which) {
  const std::size_t end = std::min(partner.find('*'), partner.size());
  std::string name = std::string(partner.substr(0, end)).append(which);
  return end < partner.size() ? name.append(partner.substr(end + 1)) : name;
}

Parameters::Parameters(std::string_view program, std::span<const ParameterInfo> own)
    : program_(program) {
  for (const auto infos : {common_parameters(), own}) {
    for (const ParameterInfo& info : infos) {
      if (info.system_help.empty()) {
        add(info);
      } else {
        add_partner(info);
      }
    }
  }
}

void Parameters::add(const ParameterInfo& info) {
  if (Entry* common = find(info.name)) {
    *common = {&info, initial_of(info), common->takes_effect};
  } else {
    entries_.push_back({&info, initial_of(info)});
  }
}

void Parameters::add_partner(const ParameterInfo& row) {
  const auto kept = [this](std::string text) -> std::string_view {
    return texts_.emplace_back(std::move(text));
  };
  ParameterInfo& instance = partners_.emplace_back(row);
  instance.name = kept(partner_parameter(row.name, "Inst"));
  instance.help = kept("instance of " + std::string(row.help));
  add(partners_.emplace_back(ParameterInfo{
      .name = kept(partner_parameter(row.name, "Sys")),
      .initial = 0,
      .help = kept("system id of " + std::string(row.system_help)),
      .min = 0,
      .max = row.max,
      .takes_effect = row.takes_effect,
  }));
  add(instance);
}

// --- reading

Parameters::Entry* Parameters::find(std::string_view name) {
  const auto found = std::ranges::find(entries_, name, [](const Entry& e) { return e.info->name; });
  return found == entries_.end() ? nullptr : &*found;
}

const Parameters::Entry& Parameters::entry(std::string_view name) const {
  const auto found = std::ranges::find(entries_, name, [](const Entry& e) { return e.info->name; });
  assert(found != entries_.end() && "every parameter is declared");
  return *found;
}

std::int32_t Parameters::integer(std::string_view name) const {
  return std::get<std::int32_t>(entry(name).value);
}

float Parameters::real(std::string_view name) const { return std::get<float>(entry(name).value); }

const std::string& Parameters::text(std::string_view name) const {
  return std::get<std::string>(entry(name).value);
}

tims::Result<void> Parameters::set_widths(const tims::AddressWidths& widths) {
  for (Entry& entry : entries_) {
    const int bits = bits_of_id(entry.info->name, widths);
    if (bits == 0) continue;
    entry.max = std::min(entry.info->max, std::exp2(bits) - 1);
    if (std::get<std::int32_t>(entry.value) <= entry.max) continue;
    return tims::Error(tims::Errc::kInvalidArgument,
                       std::string(entry.info->name) + " = " + as_text(entry.info->name) +
                           ": addresses of this fleet have " + std::to_string(widths.system) +
                           " bits for the system and " + std::to_string(widths.instance) +
                           " for the instance");
  }
  return {};
}

std::string Parameters::as_text(std::string_view name) const { return to_text(entry(name).value); }

ParameterList Parameters::list() const {
  ParameterList list;
  Parameter record;
  record.name = "name";
  record.type = Parameter::kString;
  (void)record.valueString.assign(program_);
  list.parameters.push_back(record);
  for (const Entry& entry : entries_) {
    record = {};
    (void)record.name.assign(entry.info->name);
    record.type = static_cast<i32>(entry.value.index());
    if (const auto* whole = std::get_if<std::int32_t>(&entry.value)) record.valueInt = *whole;
    if (const auto* real = std::get_if<float>(&entry.value)) record.valueFloat = *real;
    if (const auto* text = std::get_if<std::string>(&entry.value))
      (void)record.valueString.assign(*text);
    list.parameters.push_back(record);
  }
  return list;
}

ParameterEffects Parameters::effects() const {
  ParameterEffects list;
  ParameterEffect program{.takesEffect = static_cast<i32>(TakesEffect::kAtStart)};
  program.name = "name";
  list.effects.push_back(program);
  for (const Entry& entry : entries_) {
    ParameterEffect effect{.takesEffect = static_cast<i32>(entry.takes_effect)};
    (void)effect.name.assign(entry.info->name);
    list.effects.push_back(effect);
  }
  return list;
}

// --- writing

tims::Result<void> Parameters::set(std::string_view name, std::string_view value) {
  Entry* entry = find(name);
  if (entry == nullptr)
    return tims::Error(tims::Errc::kInvalidArgument, "no parameter " + std::string(name));
  ParameterValue next = std::string(value);
  if (std::holds_alternative<std::int32_t>(entry->value)) {
    const auto whole = tims::base::parse_number<std::int32_t>(value);
    if (!whole) return refused(*entry, value);
    next = *whole;
  } else if (std::holds_alternative<float>(entry->value)) {
    const auto real = tims::base::parse_number<float>(value);
    if (!real) return refused(*entry, value);
    next = *real;
  }
  return assign(*entry, std::move(next));
}

tims::Result<bool> Parameters::set(const Parameter& record, bool is_foreign) {
  Entry* entry = find(record.name.view());
  if (entry == nullptr) return false;
  if (is_unchanged(record, *entry)) return true;
  if (is_foreign && entry->info->is_host_file)
    return tims::Error(tims::Errc::kInvalidArgument,
                       std::string(entry->info->name) +
                           " names a file or device: it can be changed only by a program of the "
                           "same host at the router's socket; run timsctl there, or change the "
                           "robot file");
  auto value = value_of(record, entry->value);
  if (!value) return refused(*entry, "a value of another type");
  if (const auto good = assign(*entry, std::move(*value)); !good) return good.error();
  return true;
}

tims::Result<void> Parameters::assign(Entry& entry, ParameterValue value) {
  const auto in_range = [&](double number) {
    return number >= entry.info->min && number <= entry.max;
  };
  bool good = true;
  if (const auto* whole = std::get_if<std::int32_t>(&value)) good = in_range(*whole);
  if (const auto* real = std::get_if<float>(&value))
    good = std::isfinite(*real) && in_range(static_cast<double>(*real));
  if (const auto* text = std::get_if<std::string>(&value))
    good = text->size() <= kTextMax && text->find('\0') == std::string::npos;
  if (!good) return refused(entry, to_text(value));
  entry.value = std::move(value);
  entry.given = true;
  return {};
}

}  // namespace rack

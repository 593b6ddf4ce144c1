#include "components/runtime/logic/description.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include "base/text.h"
#include "tims/address.h"

namespace rack {
namespace {

using tims::base::in_quotes;

// One object, field by field.
class Object {
 public:
  Object& text(std::string_view key, std::string_view value) { return raw(key, in_quotes(value)); }
  Object& number(std::string_view key, double value) { return raw(key, plain(value)); }
  Object& yes(std::string_view key, bool value) { return value ? raw(key, "true") : *this; }
  Object& raw(std::string_view key, std::string_view value) {
    out_ += out_.empty() ? "{" : ", ";
    out_.append(in_quotes(key)).append(": ").append(value);
    return *this;
  }
  [[nodiscard]] std::string end() const { return out_.empty() ? "{}" : out_ + "}"; }

  static std::string plain(double value) {
    std::array<char, 32> digits{};
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
  }

 private:
  std::string out_;
};

std::string list(const std::vector<std::string>& items, std::string_view between) {
  std::string out = "[";
  for (const std::string& item : items)
    out.append(&item == items.data() ? "" : ",").append(between).append(item);
  return out + "]";
}

std::string name_of_class(std::uint32_t class_id) {
  const auto name = tims::class_name(class_id);
  return name.empty() ? std::to_string(class_id) : std::string(name);
}

// "0 RMC, 1 GGA": numbers with a meaning, or texts of which the first word is the value.
std::string choices(const ParameterInfo& info) {
  const bool is_text = std::holds_alternative<std::string_view>(info.initial);
  std::vector<std::string> items;
  for (std::string_view rest = info.choices; !rest.empty();) {
    const std::string_view item = rest.substr(0, rest.find(", "));
    rest.remove_prefix(std::min(item.size() + 2, rest.size()));
    const std::string_view value = item.substr(0, item.find(' '));
    Object choice;
    choice.raw("value", is_text ? in_quotes(value) : std::string(value));
    if (value.size() < item.size()) choice.text("meaning", item.substr(value.size() + 1));
    items.push_back(choice.end());
  }
  return list(items, items.empty() ? "" : " ");
}

// The partner that the parameter belongs to.
const UsedComponent* partner_of(std::string_view name, const Described& component) {
  const auto found = std::ranges::find_if(component.inputs, [&](const UsedComponent& input) {
    return input.system == name || input.instance == name;
  });
  return found == component.inputs.end() ? nullptr : &*found;
}

std::string_view text_of(TakesEffect when) {
  constexpr std::array<std::string_view, 3> kTexts = {"now", "on", "start"};
  return kTexts.at(static_cast<std::size_t>(when));
}

std::string parameter(const Parameters::Entry& entry, const Described& component) {
  const ParameterInfo& info = *entry.info;
  Object out;
  out.text("name", info.name);
  if (const auto* text = std::get_if<std::string_view>(&info.initial)) {
    out.text("type", "text").text("default", *text);
  } else {
    const auto* whole = std::get_if<std::int32_t>(&info.initial);
    out.text("type", whole != nullptr ? "int" : "float");
    const double initial = whole != nullptr ? *whole : std::get<float>(info.initial);
    out.number("default", initial).number("min", info.min).number("max", entry.max);
  }
  if (!info.unit().empty()) out.text("unit", info.unit());
  out.text("help", help_without_unit(info));
  if (!info.choices.empty()) out.raw("choices", choices(info));
  if (const UsedComponent* partner = partner_of(info.name, component)) {
    out.text("refers", name_of_class(partner->class_id));
    out.text("part", partner->system == info.name ? "system" : "instance");
  }
  out.text("takes_effect", text_of(entry.takes_effect));
  out.yes("required", info.required).yes("host_file", info.is_host_file);
  const auto common = common_parameters();
  out.yes("common", std::ranges::find(common, info.name, &ParameterInfo::name) != common.end());
  return out.end();
}

std::vector<std::string> inputs(const Parameters& parameters, const Described& component) {
  std::vector<std::string> items;
  for (const UsedComponent& input : component.inputs) {
    const auto all = parameters.entries();
    const auto instance = std::ranges::find(
        all, input.instance, [](const Parameters::Entry& entry) { return entry.info->name; });
    Object out;
    out.text("class", name_of_class(input.class_id));
    out.text("system", input.system).text("instance", input.instance);
    out.yes("optional", instance != all.end() && instance->info->min < 0);
    items.push_back(out.end());
  }
  return items;
}

// The parameter with the period of its data, by the names that all components use.
std::vector<std::string> outputs(const Parameters& parameters, const Described& component) {
  if (!component.has_data) return {};
  Object out;
  out.text("class", name_of_class(component.class_id)).text("message", "DATA");
  for (const auto& entry : parameters.entries()) {
    const auto* period = std::get_if<std::int32_t>(&entry.info->initial);
    const bool is_period = entry.info->name == "periodTime" || entry.info->name == "period";
    if (period == nullptr || !is_period) continue;
    out.text("period", entry.info->name).number("default_ms", *period);
    break;
  }
  return {out.end()};
}

}  // namespace

std::string description(const Parameters& parameters, const Described& component) {
  std::vector<std::string> rows;
  for (const Parameters::Entry& entry : parameters.entries())
    rows.push_back(parameter(entry, component));
  Object out;
  out.number("rack_description", 1).text("program", parameters.program());
  out.text("purpose", component.purpose).text("class", name_of_class(component.class_id));
  out.number("class_id", component.class_id).raw("parameters", list(rows, "\n  "));
  out.raw("inputs", list(inputs(parameters, component), "\n  "));
  out.raw("outputs", list(outputs(parameters, component), "\n  "));
  return out.end() + "\n";
}

}  // namespace rack

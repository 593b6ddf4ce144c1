#include "tools/configuration/description.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"

namespace timsctl::configuration {
namespace {

Description::Parameter parameter_of(const json::object& row) {
  Description::Parameter made{.name = text_at(row, "name"),
                              .type = text_at(row, "type"),
                              .initial = text_at(row, "default"),
                              .min = number_at(row, "min"),
                              .max = number_at(row, "max"),
                              .unit = text_at(row, "unit"),
                              .takes_effect = text_at(row, "takes_effect"),
                              .required = text_at(row, "required") == "true",
                              .host_file = text_at(row, "host_file") == "true"};
  for (const json::value& choice : items_of(row, "choices"))
    if (choice.is_object()) made.choices.push_back(text_at(choice.get_object(), "value"));
  return made;
}

// Values of texts are a closed list; of numbers those that have a meaning among others.
bool is_closed(const Description::Parameter& parameter) {
  return parameter.type == "text" && !parameter.choices.empty();
}

}  // namespace

std::string Description::Parameter::refusal(std::string_view value) const {
  if (is_closed(*this)) {
    if (std::ranges::find(choices, value) != choices.end()) return {};
    const auto near = base::nearest(value, choices);
    return fmt::format("must be one of {}, not \"{}\"{}", fmt::join(choices, ", "), value,
                       near ? fmt::format("; did you mean {}?", *near) : "");
  }
  if (type == "text") return {};
  const auto number = base::parse_number<double>(value);
  const bool whole = type != "int" || value.find_first_of(".eEnN") == std::string_view::npos;
  const bool good = number && whole && (!min || *number >= *min) && (!max || *number <= *max);
  if (good) return {};
  return fmt::format("must be {} from {} to {}, not {}",
                     type == "int" ? "a whole number" : "a number", min.value_or(0),
                     max.value_or(0), number ? std::string(value) : base::in_quotes(value));
}

const Description::Parameter* Description::find(std::string_view name) const {
  const auto found = std::ranges::find(parameters, name, &Parameter::name);
  return found == parameters.end() ? nullptr : &*found;
}

std::vector<std::string> Description::names() const {
  std::vector<std::string> all;
  all.reserve(parameters.size());
  for (const Parameter& parameter : parameters) all.push_back(parameter.name);
  return all;
}

std::optional<Description> description_of(const json::object& described) {
  if (number_at(described, "rack_description") != 1) return std::nullopt;
  Description made{
      .program = text_at(described, "program"),
      .class_name = text_at(described, "class"),
      .class_id = static_cast<std::uint32_t>(std::max(number_or_zero(described, "class_id"), 0.0))};
  const auto each = [&](std::string_view list, const auto& take) {
    for (const json::value& row : items_of(described, list))
      if (row.is_object()) take(row.get_object());
  };
  each("parameters",
       [&](const json::object& row) { made.parameters.push_back(parameter_of(row)); });
  each("inputs", [&](const json::object& row) {
    made.inputs.push_back({.class_name = text_at(row, "class"),
                           .system = text_at(row, "system"),
                           .instance = text_at(row, "instance"),
                           .optional = text_at(row, "optional") == "true"});
  });
  each("outputs", [&](const json::object& row) {
    made.outputs.push_back({.class_name = text_at(row, "class"),
                            .period = text_at(row, "period"),
                            .default_ms = number_or_zero(row, "default_ms")});
  });
  return made;
}

}  // namespace timsctl::configuration

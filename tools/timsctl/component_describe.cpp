// timsctl component describe: the parameters of a component with units and ranges, the components
// that it uses, and its data.
#include <algorithm>

#include <boost/json/parse.hpp>
#include <fmt/format.h>

#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {
namespace {

constexpr Column kDescribed[] = {
    {"Program", "program"}, {"Class", "class"}, {"Purpose", "purpose"}};
constexpr Column kDescribedParameters[] = {
    {"PARAMETER", "name"},   {"DEFAULT", "default"},
    {"UNIT", "unit"},        {"VALUES", "values"},
    {"REFERS TO", "refers"}, {"TAKES EFFECT", "takes_effect", Cell::kText, true},
    {"DESCRIPTION", "help"},
};
constexpr Column kDescribedInputs[] = {
    {"USES", "class"}, {"SYSTEM", "system"}, {"INSTANCE", "instance"}, {"OPTIONAL", "optional"}};
constexpr Column kDescribedOutputs[] = {
    {"SENDS", "class"}, {"MESSAGE", "message"}, {"PERIOD", "period"}, {"DEFAULT ms", "default_ms"}};

// The answer comes from another program: only its shape is known.
json::object described(const std::string& text, const std::string& component) {
  boost::system::error_code problem;
  json::value value = json::parse(text, problem);
  const bool is_description =
      !problem && value.is_object() && number_at(value.as_object(), "rack_description") == 1;
  for (const char* list : {"parameters", "inputs", "outputs"}) {
    const json::value* found = is_description ? value.as_object().if_contains(list) : nullptr;
    const bool is_list = found != nullptr && found->is_array() &&
                         std::ranges::all_of(found->as_array(), &json::value::is_object);
    if (!is_list)
      throw Failure(Exit::kVersion, "no_description",
                    component + " describes itself in a form that this timsctl does not know",
                    "use the timsctl of its version");
  }
  return std::move(value.as_object());
}

// "0 RMC, 1 GGA", "10 to 1000", or nothing for a text.
std::string values_of(const json::object& parameter) {
  std::string text;
  const json::value* choices = parameter.if_contains("choices");
  if (choices != nullptr && choices->is_array()) {
    for (const json::value& choice : choices->as_array()) {
      if (!choice.is_object()) continue;
      const std::string meaning = text_at(choice.as_object(), "meaning");
      text.append(text.empty() ? "" : ", ").append(text_at(choice.as_object(), "value"));
      text.append(meaning.empty() ? "" : " ").append(meaning);
    }
    return text;
  }
  const auto min = number_at(parameter, "min");
  const auto max = number_at(parameter, "max");
  constexpr double kNone = -2147483648.0;
  if (!min || !max) return text;
  if (*max >= -kNone - 1) return *min > kNone ? fmt::format("at least {}", *min) : "any";
  return *min > kNone ? fmt::format("{} to {}", *min, *max) : fmt::format("at most {}", *max);
}

std::string described_text(json::object answer, const Look& look) {
  for (json::value& parameter : answer.at("parameters").as_array()) {
    json::object& row = parameter.as_object();
    row["values"] = values_of(row);
    if (row.contains("required")) row["default"] = "required";
    if (text_at(row, "default").empty()) row.erase("default");
  }
  std::string text = look.for_people() ? render_page(answer, kDescribed, look) + "\n" : "";
  text += render_items(answer.at("parameters").as_array(), kDescribedParameters, look);
  if (!look.for_people()) return text;
  const auto section = [&](std::string_view list, std::span<const Column> columns) {
    const json::array& items = answer.at(list).as_array();
    if (!items.empty()) text += "\n" + render_items(items, columns, look);
  };
  section("inputs", kDescribedInputs);
  section("outputs", kDescribedOutputs);
  return text;
}

}  // namespace

Exit component_describe(Context& context) {
  ComponentClient client(context);
  const tims::Address component = client.address(context.options.arguments.front());
  const std::string name = client.name_of(component);
  json::object answer{{"schema", "tims/description/1"},
                      {"address", address_json(component, client.widths())}};
  for (auto& [key, value] : described(client.description(component), name))
    if (key != "rack_description") answer[key] = std::move(value);
  context.out.write(answer, [&] { return described_text(answer, context.out.look()); });
  return Exit::kDone;
}

}  // namespace timsctl

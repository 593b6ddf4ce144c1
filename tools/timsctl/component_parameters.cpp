#include "tools/timsctl/component_parameters.h"

#include <algorithm>

#include "rack/codec/codec.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

constexpr Column kParameters[] = {
    {"PARAMETER", "name"},
    {"VALUE", "value"},
    {"TAKES EFFECT", "takes_effect"},
    {"TYPE", "type", As::kText, true},
};

}  // namespace

json::object parameter_json(const rack::Parameter& parameter,
                            const std::optional<rack::ParameterEffects>& effects) {
  json::object item{{"name", parameter.name.view()}};
  switch (parameter.type) {
    case rack::Parameter::kInt:
      item["type"] = "int";
      item["value"] = parameter.valueInt;
      break;
    case rack::Parameter::kFloat:
      item["type"] = "float";
      item["value"] = parameter.valueFloat;
      break;
    default:
      item["type"] = "string";
      item["value"] = parameter.valueString.view();
  }
  if (const auto effect = effect_of(effects, parameter.name.view()))
    item["takes_effect"] = rack::name(*effect);
  return item;
}

rack::ParameterList get_parameters(ComponentCall& call, tims::Address component) {
  Message answer;
  waited(call.context(), [&] { return answer = call.ask(component, tims::type::kGetParam), true; });
  return value_or_fail(rack::decode<rack::ParameterList>({answer.header, answer.body}),
                       call.name_of(component));
}

std::optional<rack::ParameterEffects> get_effects(ComponentCall& call, tims::Address component) {
  return call.ask_ours<rack::ParameterEffects>(component, tims::type::kGetParamEffects,
                                               tims::type::kParamEffects);
}

std::optional<rack::TakesEffect> effect_of(const std::optional<rack::ParameterEffects>& effects,
                                           std::string_view name) {
  if (!effects) return std::nullopt;
  const auto found = std::ranges::find_if(
      effects->effects, [&](const rack::ParameterEffect& e) { return e.name.view() == name; });
  if (found == effects->effects.end()) return std::nullopt;
  return static_cast<rack::TakesEffect>(found->takesEffect);
}

std::string parameter_table(const json::array& items, const Look& look) {
  return render_items(items, kParameters, look);
}

}  // namespace timsctl

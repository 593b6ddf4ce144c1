#include "tools/timsctl/component_parameters.h"

#include "proxies/codec/codec.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

constexpr Column kParameters[] = {
    {"PARAMETER", "name"},
    {"VALUE", "value"},
    {"TYPE", "type", As::kText, true},
};

}  // namespace

json::object parameter_json(const rack::Parameter& parameter) {
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
  return item;
}

rack::ParameterList get_parameters(ComponentCall& call, tims::Address component) {
  Message answer;
  waited(call.context(), [&] { return answer = call.ask(component, tims::type::kGetParam), true; });
  return value_or_fail(rack::decode<rack::ParameterList>({answer.header, answer.body}),
                       call.name_of(component));
}

std::string parameter_table(const json::array& items, const Look& look) {
  return render_items(items, kParameters, look);
}

}  // namespace timsctl

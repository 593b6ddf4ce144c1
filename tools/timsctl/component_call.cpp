#include "tools/timsctl/component_call.h"

#include <algorithm>

#include "os/clock.h"
#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace timsctl {

Message ComponentCall::ask(tims::Address component, std::int8_t type,
                           std::span<const std::byte> body, std::optional<tims::Duration> timeout) {
  const std::uint8_t seq_nr = connection_.next_seq_nr();
  const std::uint64_t losses = connection_.losses();
  value_or_fail(
      connection_.send({.dest = component, .type = type, .seq_nr = seq_nr, .tell_why = true}, body),
      name_of(component));
  const tims::Time deadline = tims::os::deadline_after(timeout.value_or(context_.options.timeout));
  while (auto message = receive(connection_, context_.signals, deadline, losses)) {
    if (message->header.src != component || message->header.seq_nr != seq_nr) continue;
    if (message->header.type == tims::type::kNotAvailable)
      throw Failure(Exit::kNoSuch, "no_such_mailbox",
                    name_of(component) + ": nobody has registered this address",
                    "`timsctl component list` shows all");
    return std::move(*message);
  }
  throw Failure(Exit::kTimeout, "timeout", name_of(component) + " did not answer",
                "a longer --timeout? `timsctl explain` shows whether it can be reached");
}

std::optional<Message> ComponentCall::newest_data(tims::Address component) {
  Message answer = ask(component, tims::type::kGetData, rack::GetDataRequest{});
  if (answer.header.type != tims::type::kData) return std::nullopt;
  return answer;
}

std::vector<std::optional<std::int8_t>> ComponentCall::states(
    std::span<const tims::Address> components) {
  std::vector<std::optional<std::int8_t>> states(components.size());
  for (const tims::Address component : components)
    value_or_fail(connection_.send({.dest = component, .type = tims::type::kGetStatus}, {}),
                  name_of(component));
  const tims::Time deadline = tims::os::deadline_after(context_.options.timeout);
  std::size_t missing = components.size();
  while (missing > 0) {
    const auto message = receive(connection_, context_.signals, deadline);
    if (!message) break;
    const auto asked = std::ranges::find(components, message->header.src);
    if (asked == components.end()) continue;
    auto& state = states[static_cast<std::size_t>(asked - components.begin())];
    if (!state) --missing;
    state = message->header.type;
  }
  return states;
}

void need_ok(const Message& answer, const std::string& what, const std::string& hint) {
  if (answer.header.type == tims::type::kOk) return;
  const std::string_view reason = rack::reason_of(answer.body);
  if (reason.empty())
    throw Failure(Exit::kNo, "refused", what, hint + " `timsctl log follow` shows its words");
  throw Failure(Exit::kNo, "refused", what + ": " + std::string(reason), hint);
}

bool waited(const Context& context, const std::function<bool()>& attempt) {
  constexpr tims::Duration kPause = std::chrono::milliseconds(50);
  const tims::Time deadline =
      tims::os::deadline_after(context.options.wait.value_or(tims::Duration{}));
  for (;;) {
    try {
      if (attempt()) return true;
      if (tims::os::now() >= deadline) return false;
    } catch (const Failure&) {
      if (tims::os::now() >= deadline) throw;
    }
    context.signals.sleep_until(tims::os::now() + kPause);
  }
}

std::string state_text(std::int8_t state) {
  switch (state) {
    case tims::type::kEnabled:
      return "on";
    case tims::type::kDisabled:
      return "off";
    case tims::type::kError:
      return "error";
    case tims::type::kNotAvailable:
      return "gone";
    default:
      if (const std::string name = type_name(state); !name.empty()) return "answer " + name;
      return "answer " + std::to_string(state);
  }
}

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

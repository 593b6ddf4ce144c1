// timsctl component show: what a component is and how it is doing.
#include <algorithm>

#include <fmt/format.h>

#include "proxies/codec/codec.h"
#include "proxies/generic.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/component_call.h"
#include "tools/timsctl/component_parameters.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/message_text.h"

namespace timsctl {

namespace {

constexpr Column kState[] = {
    {"Address", "address.name"},
    {"Raw address", "address.raw"},
    {"State", "state"},
    {"Since", "since_s", As::kDuration},
};

constexpr Column kRealTime[] = {
    {"Watched", "watch"},
    {"Loops", "loops", As::kCount},
    {"Blocked", "blocked", As::kCount},
    {"Preempted", "preempted", As::kCount},
    {"Page faults", "page_faults", As::kCount},
    {"Lost", "lost", As::kCount},
};

constexpr Column kPlaces[] = {
    {"NOT IN REAL TIME", "kind"},
    {"TIMES", "count", As::kCount},
    {"WHERE, INNERMOST FIRST", "where"},
};

constexpr Column kData[] = {
    {"Period", "period_s", As::kDuration},
    {"Data sets", "data_sets", As::kCount},
};

constexpr Column kListeners[] = {
    {"LISTENER", "address.name"},
    {"RAW", "address.raw", As::kText, true},
    {"PERIOD", "period_s", As::kDuration},
    {"PRIORITY", "priority"},
};

constexpr std::string_view kNoMember =
    "It is not made with this runtime: nothing more is known of it.";

double seconds(rack::Milliseconds<rack::u32> period) {
  return static_cast<double>(period.raw()) / 1000;
}

// The clocks of two hosts may differ a little.
double seconds_since(rack::TimeStamp time) {
  const auto now = rack::TimeStamp::of(
      std::chrono::duration_cast<std::chrono::milliseconds>(wall_now().time_since_epoch()));
  return std::max(std::chrono::duration<double>(now - time).count(), 0.0);
}

json::object real_time_json(const rack::RuntimeData& data) {
  json::array places;
  for (const rack::RuntimePlace& place : data.places)
    places.push_back(
        {{"kind", place.kind == rack::RuntimePlace::kPageFault ? "page fault" : "blocked"},
         {"count", place.count},
         {"where", place.where.view()}});
  return {{"watch", rack::name(static_cast<rack::WatchDepth>(data.watch))},
          {"loops", data.loops},
          {"blocked", data.blocked},
          {"preempted", data.preempted},
          {"page_faults", data.pageFaults},
          {"lost", data.lost},
          {"places", std::move(places)}};
}

json::object data_json(const rack::ListenersData& data, const tims::AddressWidths& widths) {
  json::array listeners;
  for (const rack::ListenerInfo& listener : data.listeners)
    listeners.push_back({{"address", address_json(listener.mailbox, widths)},
                         {"period_s", seconds(listener.periodTime)},
                         {"priority", listener.priority}});
  return {{"period_s", seconds(data.periodTime)},
          {"data_sets", data.dataSets},
          {"listeners", std::move(listeners)}};
}

json::object ask_all(ComponentCall& call, tims::Address component,
                     const tims::AddressWidths& widths) {
  namespace type = tims::type;
  json::object answer{{"schema", "tims/component/1"},
                      {"address", address_json(component, widths)},
                      {"state", state_text(call.ask(component, type::kGetStatus).header.type)}};
  const auto runtime =
      call.ask_ours<rack::RuntimeData>(component, type::kGetRuntime, type::kRuntime);
  answer["member"] = runtime.has_value();
  if (runtime) {
    answer["since_s"] = seconds_since(runtime->since);
    answer["real_time"] = real_time_json(*runtime);
    const auto data =
        call.ask_ours<rack::ListenersData>(component, type::kGetListeners, type::kListeners);
    if (data) answer["data"] = data_json(*data, widths);
  }
  const auto effects = runtime ? get_effects(call, component) : std::nullopt;
  json::array parameters;
  for (const rack::Parameter& parameter : get_parameters(call, component).parameters)
    parameters.push_back(parameter_json(parameter, effects));
  answer["parameters"] = std::move(parameters);
  return answer;
}

// A table below what stands already; an empty one is left out.
std::string section(const json::value& items, std::span<const Column> columns, const Look& look) {
  if (items.as_array().empty()) return "";
  return "\n" + render_items(items.as_array(), columns, look);
}

std::string text_of(const json::object& answer, const Look& look) {
  std::string text = render_page(answer, kState, look);
  if (const json::value* found = answer.if_contains("real_time")) {
    const json::object& real_time = found->as_object();
    text += "\nReal time\n" + render_page(real_time, kRealTime, look);
    text += section(real_time.at("places"), kPlaces, look);
  } else {
    text += fmt::format("{}\n", kNoMember);
  }
  if (const json::value* found = answer.if_contains("data")) {
    const json::object& data = found->as_object();
    text += "\nData\n" + render_page(data, kData, look);
    text += section(data.at("listeners"), kListeners, look);
  }
  return text + "\n" + parameter_table(answer.at("parameters").as_array(), look);
}

}  // namespace

Exit component_show(Context& context) {
  const auto connection = context.connect({.address = {}, .body_max = 64U << 10});
  ComponentCall call(context, *connection);
  const tims::Address component =
      need_address(context.options.arguments.front(), connection->widths());
  const json::object answer = ask_all(call, component, connection->widths());
  if (context.out.json()) {
    context.out.write(answer);
  } else {
    context.out.write(text_of(answer, context.out.look()));
  }
  return Exit::kDone;
}

}  // namespace timsctl

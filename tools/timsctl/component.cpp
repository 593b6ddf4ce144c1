// timsctl component: shows and controls components.
#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "proxies/message_files.h"
#include "rack/codec/codec.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/generic.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"
#include "tools/timsctl/message.h"

namespace timsctl {
namespace {

constexpr tims::Duration kComponentOnPatience = std::chrono::seconds(5);

constexpr Column kList[] = {
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw", Cell::kText, true},
    {"STATE", "state"},
    {"PROGRAM", "program"},
    {"PID", "owner.pid"},
    {"VIA", "via"},
    {"AT", "at", Cell::kText, true},
    {"AGE", "age_s", Cell::kDuration},
};

constexpr Column kStates[] = {
    {"ADDRESS", "address.name"}, {"RAW", "address.raw", Cell::kText, true}, {"STATE", "state"}};

bool is_behind_a_link(const json::object& item) { return text_at(item, "owner.port") == "link"; }

// Asks every router for its own components and their programs. The first router alone is not
// sufficient: a robot does not know the components of its neighbours.
json::object everywhere(AdminClient& admin, const json::object& question) {
  json::object answer = ask_everywhere(admin, question);
  json::array here;
  for (json::value& item : item_array(answer))
    if (!is_behind_a_link(item.as_object())) here.push_back(std::move(item));
  answer["items"] = std::move(here);
  return answer;
}

// The items of components, as reported by the routers, with the state of each component.
void add_states(json::object& answer, ComponentClient& client, const tims::AddressWidths& widths) {
  json::array components;
  std::vector<tims::Address> addresses;
  for (json::object component : objects(items_of(answer))) {
    const auto address = parse_address(text_at(component, "address.raw"), widths);
    if (!address || !is_component(*address, widths)) continue;
    addresses.push_back(*address);
    // For a component behind a link, this router knows only the other router as the owner.
    const bool behind = is_behind_a_link(component);
    component["program"] = behind ? json::value() : json::value(text_at(component, "owner.name"));
    components.push_back(std::move(component));
  }
  const auto states = client.states(addresses);
  for (std::size_t i = 0; i < states.size(); ++i)
    components[i].as_object()["state"] = states[i] ? state_text(*states[i]) : "silent";
  answer["items"] = std::move(components);
}

// A component answers to OFF before it is off.
void wait_until_off(Context& context, ComponentClient& client, tims::Address component) {
  const tims::Time deadline = tims::os::deadline_after(context.options.timeout);
  while (client.ask(component, tims::type::kGetStatus).header.type != tims::type::kDisabled) {
    if (tims::os::now() > deadline)
      throw Failure(Exit::kTimeout, "timeout", client.name_of(component) + " is not off yet",
                    "use a longer --timeout, or --no-wait");
    context.signals.sleep_until(tims::os::deadline_after(std::chrono::milliseconds(20)));
  }
}

// Empty on success, else the reason, which is an empty string for components of the original RACK.
std::optional<std::string> turn(Context& context, ComponentClient& client, tims::Address component,
                                bool on) {
  const auto patience =
      on && !context.options.has_timeout ? kComponentOnPatience : context.options.timeout;
  const Message answer = on ? client.ask(component, tims::type::kOn, rack::OnRequest{}, patience)
                            : client.ask(component, tims::type::kOff, {}, patience);
  if (answer.header.type != tims::type::kOk) return std::string(rack::reason_of(answer.body));
  if (!on && !context.options.no_wait) wait_until_off(context, client, component);
  return std::nullopt;
}

Exit turn_all(Context& context, bool on) {
  ComponentClient client(context);
  Exit exit = Exit::kDone;
  for (const tims::Address component : need_addresses(context.options.arguments, client.widths())) {
    std::optional<std::string> refused;
    const bool done =
        waited(context, [&] { return !(refused = turn(context, client, component, on)); });
    if (!done) exit = Exit::kNo;
    json::object answer{{"schema", "tims/component_switched/1"},
                        {"address", address_json(component, client.widths())},
                        {"done", done}};
    if (!done && !refused->empty()) answer["reason"] = *refused;
    context.out.write(answer, [&] {
      return fmt::format("{} {}\n", client.name_of(component), done ? "ok" : "error");
    });
    if (!done)
      context.out.note(client.name_of(component) +
                       (refused->empty() ? " refuses; `timsctl log follow` shows its messages"
                                         : ": " + *refused));
  }
  return exit;
}

// --- parameters

constexpr Column kParameters[] = {
    {"PARAMETER", "name"},
    {"VALUE", "value"},
    {"TAKES EFFECT", "takes_effect"},
    {"TYPE", "type", Cell::kText, true},
};

const rack::Parameter& find(const rack::ParameterList& list, std::string_view name,
                            const std::string& component) {
  const auto found = std::ranges::find_if(
      list.parameters, [&](const rack::Parameter& p) { return p.name.view() == name; });
  if (found == list.parameters.end())
    throw Failure(Exit::kNoSuch, "no_such_parameter",
                  fmt::format("{} has no parameter {}", component, name),
                  "`timsctl component param get ADDR` shows all");
  return *found;
}

template <typename Number>
Number number(std::string_view text, std::string_view name) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw usage_error(fmt::format("{} is not a value for {}", text, name));
  return value;
}

void assign(rack::Parameter& parameter, std::string_view text) {
  const std::string_view name = parameter.name.view();
  if (parameter.type == rack::Parameter::kInt) {
    parameter.valueInt = number<std::int32_t>(text, name);
  } else if (parameter.type == rack::Parameter::kFloat) {
    parameter.valueFloat = number<float>(text, name);
  } else if (!parameter.valueString.assign(text)) {
    throw usage_error(fmt::format("{} is too long for {}: at most 79 bytes", text, name));
  }
}

Exit param_get(Context& context) {
  const auto& arguments = context.options.arguments;
  ComponentClient client(context);
  const tims::Address component = client.address(arguments[1]);
  const rack::ParameterList list = client.parameters(component);
  const auto effects = client.effects(component);
  json::array items;
  if (arguments.size() > 2)
    items.push_back(parameter_json(find(list, arguments[2], client.name_of(component)), effects));
  else
    for (const rack::Parameter& parameter : list.parameters)
      items.push_back(parameter_json(parameter, effects));
  context.out.write({{"schema", "tims/parameters/1"},
                     {"address", address_json(component, client.widths())},
                     {"items", items}},
                    [&] { return render_items(items, kParameters, context.out.look()); });
  return Exit::kDone;
}

Exit param_set(Context& context) {
  const auto& arguments = context.options.arguments;
  if (arguments.size() != 4) throw usage_error("component param set ADDR NAME VALUE");
  ComponentClient client(context);
  const tims::Address component = client.address(arguments[1]);
  const std::string name = client.name_of(component);
  rack::ParameterList request;
  request.parameters.push_back(find(client.parameters(component), arguments[2], name));
  assign(request.parameters[0], arguments[3]);
  const auto effects = client.effects(component);
  need_ok(client.ask(component, tims::type::kSetParam, request),
          fmt::format("{} refuses {} = {}", name, arguments[2], arguments[3]),
          "see --help of the component for valid values");
  if (context.out.json())
    context.out.write(json::object{{"schema", "tims/parameter_set/1"},
                                   {"address", address_json(component, client.widths())},
                                   {"parameter", parameter_json(request.parameters[0], effects)}});
  const auto effect = effect_of(effects, arguments[2]);
  context.out.note(fmt::format("{}: {} = {}, {}", name, arguments[2], arguments[3],
                               effect
                                   ? fmt::format("takes effect {}", rack::name(*effect))
                                   : "it does not report when; most take effect at the next ON"));
  return Exit::kDone;
}

void show_data(Context& context, tims::Address component, const Message& newest,
               const rack::Schema& body, const FieldStyle& style, std::optional<double> age_s) {
  const Format format = context.out.look().format;
  if (format == Format::kTable || format == Format::kWide) {
    const rack::PrintStyle print{
        .elements_max = format == Format::kWide ? rack::kAllElements : style.elements_max,
        .si = style.si,
        .widths = style.widths};
    return context.out.write(
        value_or_fail(rack::body_text(body, newest.body, newest.header.body_order(), print),
                      component.to_string(style.widths)));
  }
  FieldStyle all = style;
  all.elements_max = rack::kAllElements;
  json::object described = described_json(newest, tims::os::wall_now(), all);
  if (format == Format::kCsv) return context.out.write(CsvLines().add(described));
  if (const json::value* damage = described.if_contains("malformed"))
    throw Failure(Exit::kVersion, "malformed", std::string(damage->as_string()));
  json::object answer{
      {"schema", "tims/component_data/1"}, {"address", address_json(component, style.widths)},
      {"time", described["time"]},         {"body", described["body"]},
      {"units", described["units"]},       {"data", described["data"]}};
  if (age_s) answer["age_s"] = *age_s;
  context.out.write(answer);
}

}  // namespace

Exit component_list(Context& context) {
  ComponentClient client(context);
  const auto ask = [&](AdminClient& admin) {
    json::object answer;
    waited(context, [&] {
      const json::object question = with_match({{"ask", "mailboxes"}}, context.options);
      answer = context.options.all_routers ? everywhere(admin, question) : admin.ask(question);
      // The pattern may match components of another robot.
      if (!context.options.arguments.empty() && items_of(answer).empty())
        answer = everywhere(admin, question);
      add_states(answer, client, admin.widths());
      return !items_of(answer).empty();
    });
    const std::string& by = context.options.sort;
    if (!by.empty()) sort_items(item_array(answer), kList, by);
    return answer;
  };
  return show(context, ask, table_of(kList));
}

// Exit status 1: not all of them are on.
Exit component_status(Context& context) {
  ComponentClient client(context);
  const auto components = need_addresses(context.options.arguments, client.widths());
  std::vector<std::optional<std::int8_t>> states;
  waited(context, [&] {
    states = client.states(components);
    return std::ranges::all_of(states,
                               [](const auto& state) { return state == tims::type::kEnabled; });
  });
  Exit exit = Exit::kDone;
  json::array items;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const std::string state = states[i] ? state_text(*states[i]) : "silent";
    if (state != "on") exit = Exit::kNo;
    json::object item{{"schema", "tims/component_status/1"},
                      {"address", address_json(components[i], client.widths())},
                      {"state", state}};
    if (!states[i] || *states[i] == tims::type::kNotAvailable) {
      if (const auto broken = client.why_absent(components[i])) {
        item["reason"] = broken->cause;
        context.out.note(fmt::format("{}: {}; {}", client.name_of(components[i]), broken->cause,
                                     broken->remedy));
      }
    }
    items.push_back(std::move(item));
  }
  const Format format = context.out.look().format;
  if (format != Format::kJson && format != Format::kTable)
    context.out.write(render_items(items, kStates, context.out.look()));
  else
    for (const json::object& item : objects(items))
      context.out.write(item, [&] {
        return fmt::format("{} {}\n", text_at(item, "address.name"), text_at(item, "state"));
      });
  return exit;
}

Exit component_on(Context& context) { return turn_all(context, true); }
Exit component_off(Context& context) { return turn_all(context, false); }

Exit component_param(Context& context) {
  const std::string& verb = context.options.arguments.front();
  if (verb == "get") return param_get(context);
  if (verb == "set") return param_set(context);
  const auto more = std::span(context.options.arguments).subspan(1);
  // Only the program that started the component knows its file.
  if (verb == "save" && more.size() < 3) become_verb("timsctl-robot", verb, context.options, more);
  throw usage_error("component param get ADDR [NAME], set ADDR NAME VALUE, or save ADDR [NAME]");
}

Exit component_data(Context& context) {
  ComponentClient client(context, {.address = {}, .body_max = context.options.body_max_bytes});
  const tims::Address component = client.address(context.options.arguments.front());
  std::optional<Message> newest;
  std::optional<double> age_s;
  waited(context, [&] {
    newest =
        context.options.newest ? client.kept_data(component, age_s) : client.newest_data(component);
    return newest.has_value();
  });
  if (!newest && context.options.newest)
    throw Failure(Exit::kNo, "none_kept",
                  "the router keeps no data of " + client.name_of(component),
                  "it keeps samples that pass it, of the classes in newest.streams: somebody "
                  "behind it must subscribe to them, such as `timsctl msg echo ADDR` does");
  if (!newest)
    throw Failure(Exit::kNo, "no_data", client.name_of(component) + " has no data",
                  "is it on? `timsctl component status ADDR`");
  const FieldStyle style{.widths = client.widths(),
                         .utc = context.options.utc,
                         .si = context.options.si,
                         .fields = true,
                         .elements_max = context.out.terminal() ? 20 : rack::kAllElements};
  const rack::MessageInfo* info = rack::find_message(newest->header, style.widths);
  if (info == nullptr || info->body == nullptr) {
    const std::string why = undescribed(component.fields(style.widths).class_id);
    throw Failure(Exit::kNo, "unknown_class",
                  fmt::format("{}: {}", client.name_of(component),
                              why.empty() ? "data of no known form" : why),
                  fmt::format("{}`timsctl msg echo ADDR -n 1` shows the bytes",
                              why.empty() ? "" : rack::message_places() + "; "));
  }
  if (age_s) context.out.note(fmt::format("{:.1f} s old", *age_s));
  show_data(context, component, *newest, *info->body, style, age_s);
  return Exit::kDone;
}

// --- component show: details of a component

namespace {

constexpr Column kState[] = {
    {"Address", "address.name"},
    {"Raw address", "address.raw"},
    {"State", "state"},
    {"Since", "since_s", Cell::kDuration},
};

constexpr Column kRealTime[] = {
    {"Watched", "watch"},
    {"Loops", "loops", Cell::kCount},
    {"Blocked", "blocked", Cell::kCount},
    {"Preempted", "preempted", Cell::kCount},
    {"Page faults", "page_faults", Cell::kCount},
    {"Lost", "lost", Cell::kCount},
};

constexpr Column kPlaces[] = {
    {"NOT IN REAL TIME", "kind"},
    {"TIMES", "count", Cell::kCount},
    {"WHERE, INNERMOST FIRST", "where"},
};

constexpr Column kData[] = {
    {"Period", "period_s", Cell::kDuration},
    {"Data sets", "data_sets", Cell::kCount},
};

constexpr Column kListeners[] = {
    {"LISTENER", "address.name"},
    {"RAW", "address.raw", Cell::kText, true},
    {"PERIOD", "period_s", Cell::kDuration},
    {"PRIORITY", "priority"},
};

constexpr std::string_view kNoMember =
    "The component does not use this runtime: no further details are available.";

double seconds(rack::Milliseconds<rack::u32> period) {
  return static_cast<double>(period.raw()) / 1000;
}

// The clocks of two hosts may differ a little.
double seconds_since(rack::TimeStamp time) {
  const auto now = rack::TimeStamp::of(std::chrono::duration_cast<std::chrono::milliseconds>(
      tims::os::wall_now().time_since_epoch()));
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

json::object ask_all(ComponentClient& client, tims::Address component,
                     const tims::AddressWidths& widths) {
  namespace type = tims::type;
  json::object answer{{"schema", "tims/component/1"},
                      {"address", address_json(component, widths)},
                      {"state", state_text(client.ask(component, type::kGetStatus).header.type)}};
  const auto runtime =
      client.ask_ours<rack::RuntimeData>(component, type::kGetRuntime, type::kRuntime);
  answer["member"] = runtime.has_value();
  if (runtime) {
    answer["since_s"] = seconds_since(runtime->since);
    answer["real_time"] = real_time_json(*runtime);
    const auto data =
        client.ask_ours<rack::ListenersData>(component, type::kGetListeners, type::kListeners);
    if (data) answer["data"] = data_json(*data, widths);
  }
  const auto effects = runtime ? client.effects(component) : std::nullopt;
  json::array parameters;
  for (const rack::Parameter& parameter : client.parameters(component).parameters)
    parameters.push_back(parameter_json(parameter, effects));
  answer["parameters"] = std::move(parameters);
  return answer;
}

// Appends a table; an empty one is left out.
std::string section(const json::value& items, std::span<const Column> columns, const Look& look) {
  if (items.as_array().empty()) return "";
  return "\n" + render_items(items.as_array(), columns, look);
}

std::string answer_text(const json::object& answer, const Look& look) {
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
  return text + "\n" + render_items(answer.at("parameters").as_array(), kParameters, look);
}

}  // namespace

Exit component_show(Context& context) {
  ComponentClient client(context);
  const tims::Address component = client.address(context.options.arguments.front());
  const json::object answer = ask_all(client, component, client.widths());
  context.out.write(answer, [&] { return answer_text(answer, context.out.look()); });
  return Exit::kDone;
}

// --- component pilot: the pilot that may drive a chassis

namespace {

// Setting any other address would prevent all pilots from driving the chassis.
void need_class_of(tims::Address address, std::uint32_t wanted, std::string_view what,
                   std::string_view example, const tims::AddressWidths& widths) {
  if (address.fields(widths).class_id == wanted) return;
  throw usage_error(fmt::format("{} is not a {}", address.to_string(widths), what),
                    fmt::format("such as {}", example));
}

void set_pilot(ComponentClient& client, tims::Address chassis, tims::Address pilot) {
  if (client.ask(chassis, tims::type::kGetStatus).header.type != tims::type::kEnabled)
    throw Failure(Exit::kNo, "component_off",
                  client.name_of(chassis) + " is not on, and resets its pilot when it is turned on",
                  "first run `timsctl component on ADDR`");
  const auto type = static_cast<std::int8_t>(rack::ChassisType::kSetActivePilot);
  need_ok(client.ask(chassis, type, rack::ChassisSetActivePilotData{pilot}),
          client.name_of(chassis) + " refuses the pilot", "is it a chassis?");
}

std::optional<tims::Address> get_pilot(ComponentClient& client, tims::Address chassis) {
  const auto newest = client.newest_data(chassis);
  if (!newest)
    throw Failure(Exit::kNo, "no_data", client.name_of(chassis) + " has no data",
                  "it reports its pilot only when it is on: `timsctl component on ADDR`");
  const auto data =
      value_or_fail(rack::decode<rack::ChassisData>(newest->view()), client.name_of(chassis));
  const tims::Address pilot = data.activePilot;
  return pilot == rack::kNoPilot ? std::nullopt : std::optional(pilot);
}

}  // namespace

Exit component_pilot(Context& context) {
  const auto& arguments = context.options.arguments;
  ComponentClient client(context);
  const tims::AddressWidths widths = client.widths();
  const tims::Address chassis = client.address(arguments[0]);
  need_class_of(chassis, tims::class_id::kChassis, "chassis", "Chassis/0/0", widths);
  std::optional<tims::Address> pilot;
  if (arguments.size() > 1) {
    if (arguments[1] != "none") {
      pilot = client.address(arguments[1]);
      need_class_of(*pilot, tims::class_id::kPilot, "pilot", "Pilot/0/1, or none", widths);
    }
    waited(context,
           [&] { return set_pilot(client, chassis, pilot.value_or(rack::kNoPilot)), true; });
  } else {
    waited(context, [&] { return pilot = get_pilot(client, chassis), true; });
  }
  context.out.write({{"schema", "tims/active_pilot/1"},
                     {"chassis", address_json(chassis, widths)},
                     {"pilot", pilot ? json::value(address_json(*pilot, widths)) : nullptr}},
                    [&] { return (pilot ? client.name_of(*pilot) : "none") + "\n"; });
  return Exit::kDone;
}

}  // namespace timsctl

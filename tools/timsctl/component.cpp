// timsctl component: what components do, and telling them what to do.
#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "os/clock.h"
#include "proxies/codec/codec.h"
#include "proxies/generic.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/component_call.h"
#include "tools/timsctl/component_parameters.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/fleet.h"
#include "tools/timsctl/message_fields.h"
#include "tools/timsctl/message_text.h"
#include "tools/timsctl/show.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

// Below are routers, the sink of texts, and people's programs.
constexpr std::uint32_t kFirstComponentClass = tims::class_id::kTest;
constexpr tims::Duration kOnPatience = std::chrono::seconds(5);

constexpr Column kList[] = {
    {"ADDRESS", "address.name"},
    {"RAW", "address.raw", As::kText, true},
    {"STATE", "state"},
    {"PROGRAM", "program"},
    {"PID", "owner.pid"},
    {"VIA", "via"},
    {"AT", "at", As::kText, true},
    {"AGE", "age_s", As::kDuration},
};

constexpr Column kStates[] = {
    {"ADDRESS", "address.name"}, {"RAW", "address.raw", As::kText, true}, {"STATE", "state"}};

bool is_component(tims::Address address, const tims::AddressWidths& widths) {
  const auto fields = address.fields(widths);
  return fields.local == 0 && fields.class_id >= kFirstComponentClass;
}

bool is_behind_a_link(const json::object& item) { return text_at(item, "owner.port") == "link"; }

// From the router of each, with its program. Which of them the router asked first knows as well
// does not matter: a robot knows nothing of its neighbours.
json::object everywhere(AdminClient& admin, const json::object& question) {
  json::object answer = ask_everywhere(admin, question);
  json::array here;
  for (json::value& item : items_of(answer))
    if (!is_behind_a_link(item.as_object())) here.push_back(std::move(item));
  answer["items"] = std::move(here);
  return answer;
}

// The routers' items of components, each with its state.
void add_states(json::object& answer, ComponentCall& call, const tims::AddressWidths& widths) {
  json::array components;
  std::vector<tims::Address> addresses;
  for (const json::value& item : items_of(std::as_const(answer))) {
    const auto address = parse_address(text_at(item.as_object(), "address.raw"), widths);
    if (!address || !is_component(*address, widths)) continue;
    addresses.push_back(*address);
    json::object component = item.as_object();
    // Behind a link the owner that this router knows is the other router.
    const bool behind = is_behind_a_link(component);
    component["program"] = behind ? json::value() : json::value(text_at(component, "owner.name"));
    components.push_back(std::move(component));
  }
  const auto states = call.states(addresses);
  for (std::size_t i = 0; i < states.size(); ++i)
    components[i].as_object()["state"] = states[i] ? state_text(*states[i]) : "silent";
  answer["items"] = std::move(components);
}

// A component answers OFF before it is off.
void wait_until_off(Context& context, ComponentCall& call, tims::Address component) {
  const tims::Time deadline = tims::os::deadline_after(context.options.timeout);
  while (call.ask(component, tims::type::kGetStatus).header.type != tims::type::kDisabled) {
    if (tims::os::now() > deadline)
      throw Failure(Exit::kTimeout, "timeout", call.name_of(component) + " is not off yet",
                    "a longer --timeout, or --no-wait");
    context.signals.sleep_until(tims::os::deadline_after(std::chrono::milliseconds(20)));
  }
}

// Nothing, or what it says why not: empty when it is one of the original, which has no words.
std::optional<std::string> turn(Context& context, ComponentCall& call, tims::Address component,
                                bool on) {
  const auto patience =
      on ? std::max(kOnPatience, context.options.timeout) : context.options.timeout;
  const Message answer = on ? call.ask(component, tims::type::kOn, rack::OnRequest{}, patience)
                            : call.ask(component, tims::type::kOff, {}, patience);
  if (answer.header.type != tims::type::kOk) return std::string(rack::reason_of(answer.body));
  if (!on && !context.options.no_wait) wait_until_off(context, call, component);
  return std::nullopt;
}

Exit turn_all(Context& context, bool on) {
  const auto connection = context.connect();
  ComponentCall call(context, *connection);
  Exit exit = Exit::kDone;
  for (const tims::Address component :
       need_addresses(context.options.arguments, connection->widths())) {
    std::optional<std::string> refused;
    const bool done =
        waited(context, [&] { return !(refused = turn(context, call, component, on)); });
    if (!done) exit = Exit::kNo;
    if (context.out.json()) {
      json::object answer{{"schema", "tims/component_switched/1"},
                          {"address", address_json(component, connection->widths())},
                          {"done", done}};
      if (!done && !refused->empty()) answer["reason"] = *refused;
      context.out.write(answer);
    } else {
      context.out.write(fmt::format("{} {}\n", call.name_of(component), done ? "ok" : "error"));
    }
    if (!done)
      context.out.note(
          call.name_of(component) +
          (refused->empty() ? " says no; `timsctl log follow` shows its words" : ": " + *refused));
  }
  return exit;
}

// --- parameters

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
    throw usage_error(fmt::format("{} is no value for {}", text, name));
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
  const auto connection = context.connect({.address = {}, .body_max = 64U << 10});
  ComponentCall call(context, *connection);
  const tims::Address component = need_address(arguments[1], connection->widths());
  const rack::ParameterList list = get_parameters(call, component);
  const auto effects = get_effects(call, component);
  json::array items;
  if (arguments.size() > 2) {
    items.push_back(parameter_json(find(list, arguments[2], call.name_of(component)), effects));
  } else {
    for (const rack::Parameter& parameter : list.parameters)
      items.push_back(parameter_json(parameter, effects));
  }
  if (context.out.json()) {
    context.out.write(json::object{{"schema", "tims/parameters/1"},
                                   {"address", address_json(component, connection->widths())},
                                   {"items", items}});
  } else {
    context.out.write(parameter_table(items, context.out.look()));
  }
  return Exit::kDone;
}

Exit param_set(Context& context) {
  const auto& arguments = context.options.arguments;
  if (arguments.size() != 4) throw usage_error("component param set ADDR NAME VALUE");
  const auto connection = context.connect({.address = {}, .body_max = 64U << 10});
  ComponentCall call(context, *connection);
  const tims::Address component = need_address(arguments[1], connection->widths());
  const std::string name = call.name_of(component);
  rack::ParameterList wish;
  wish.parameters.push_back(find(get_parameters(call, component), arguments[2], name));
  assign(wish.parameters[0], arguments[3]);
  const auto effects = get_effects(call, component);
  need_ok(call.ask(component, tims::type::kSetParam, wish),
          fmt::format("{} does not take {} = {}", name, arguments[2], arguments[3]),
          "its --help says what it may be");
  if (context.out.json())
    context.out.write(json::object{{"schema", "tims/parameter_set/1"},
                                   {"address", address_json(component, connection->widths())},
                                   {"parameter", parameter_json(wish.parameters[0], effects)}});
  const auto effect = effect_of(effects, arguments[2]);
  context.out.note(fmt::format("{}: {} = {}, {}", name, arguments[2], arguments[3],
                               effect ? fmt::format("takes effect {}", rack::name(*effect))
                                      : "most take effect at the next ON; it does not say which"));
  return Exit::kDone;
}

void show_data(Context& context, tims::Address component, const Message& newest,
               const rack::BodyInfo& body, const FieldStyle& style) {
  const Format format = context.out.look().format;
  if (format == Format::kTable || format == Format::kWide) {
    const rack::PrintStyle print{
        .elements_max = format == Format::kWide ? rack::kAllElements : style.elements_max,
        .si = style.si,
        .widths = style.widths};
    return context.out.write(
        value_or_fail(body.text(newest.body, newest.header.body_order(), print),
                      component.to_string(style.widths)));
  }
  FieldStyle all = style;
  all.elements_max = rack::kAllElements;
  json::object described = described_json(newest, wall_now(), all);
  if (format == Format::kCsv) return context.out.write(CsvLines().add(described));
  if (const json::value* damage = described.if_contains("malformed"))
    throw Failure(Exit::kVersion, "malformed", std::string(damage->as_string()));
  context.out.write(json::object{{"schema", "tims/component_data/1"},
                                 {"address", address_json(component, style.widths)},
                                 {"time", described["time"]},
                                 {"body", described["body"]},
                                 {"units", described["units"]},
                                 {"data", described["data"]}});
}

}  // namespace

Exit component_list(Context& context) {
  const auto connection = context.connect();
  ComponentCall call(context, *connection);
  const auto ask = [&](AdminClient& admin) {
    json::object answer;
    waited(context, [&] {
      const json::object question = with_match({{"ask", "mailboxes"}}, context.options);
      answer = context.options.all_routers ? everywhere(admin, question) : admin.ask(question);
      // What somebody asks for by address may be of another robot.
      if (!context.options.arguments.empty() && items_of(std::as_const(answer)).empty())
        answer = everywhere(admin, question);
      add_states(answer, call, admin.widths());
      return !items_of(std::as_const(answer)).empty();
    });
    const std::string& by = context.options.sort;
    if (!by.empty()) sort_items(items_of(answer), kList, by);
    return answer;
  };
  const auto draw = [&](const json::object& answer, const Look& look) {
    return render_items(items_of(answer), kList, look);
  };
  return show(context, ask, draw);
}

// Exit status 1: one of them is not on.
Exit component_status(Context& context) {
  const auto connection = context.connect();
  ComponentCall call(context, *connection);
  const auto components = need_addresses(context.options.arguments, connection->widths());
  std::vector<std::optional<std::int8_t>> states;
  waited(context, [&] {
    states = call.states(components);
    return std::ranges::all_of(states,
                               [](const auto& state) { return state == tims::type::kEnabled; });
  });
  Exit exit = Exit::kDone;
  json::array items;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const std::string state = states[i] ? state_text(*states[i]) : "silent";
    if (state != "on") exit = Exit::kNo;
    items.push_back(json::object{{"schema", "tims/component_status/1"},
                                 {"address", address_json(components[i], connection->widths())},
                                 {"state", state}});
  }
  if (context.out.json()) {
    for (const json::value& item : items) context.out.write(item.as_object());
  } else if (context.out.look().format == Format::kTable) {
    for (const json::value& item : items)
      context.out.write(fmt::format("{} {}\n", text_at(item.as_object(), "address.name"),
                                    text_at(item.as_object(), "state")));
  } else {
    context.out.write(render_items(items, kStates, context.out.look()));
  }
  return exit;
}

Exit component_on(Context& context) { return turn_all(context, true); }
Exit component_off(Context& context) { return turn_all(context, false); }

Exit component_param(Context& context) {
  const std::string& verb = context.options.arguments.front();
  if (verb == "get") return param_get(context);
  if (verb == "set") return param_set(context);
  if (verb == "save" && context.options.arguments.size() < 4) return save_parameters(context);
  throw usage_error("component param get ADDR [NAME], set ADDR NAME VALUE, or save ADDR [NAME]");
}

Exit component_data(Context& context) {
  const auto connection =
      context.connect({.address = {}, .body_max = context.options.body_max_bytes});
  ComponentCall call(context, *connection);
  const tims::Address component =
      need_address(context.options.arguments.front(), connection->widths());
  std::optional<Message> newest;
  waited(context, [&] { return (newest = call.newest_data(component)).has_value(); });
  if (!newest)
    throw Failure(Exit::kNo, "no_data", call.name_of(component) + " has no data",
                  "is it on? `timsctl component status ADDR`");
  const FieldStyle style{.widths = connection->widths(),
                         .utc = context.options.utc,
                         .si = context.options.si,
                         .fields = true,
                         .elements_max = context.out.terminal() ? 20 : rack::kAllElements};
  const rack::MessageInfo* info = rack::find_message(newest->header, style.widths);
  if (info == nullptr || info->body == nullptr)
    throw Failure(Exit::kNo, "unknown_class",
                  call.name_of(component) + ": data of an unknown class",
                  "`timsctl msg echo ADDR -n 1` shows the bytes");
  show_data(context, component, *newest, *info->body, style);
  return Exit::kDone;
}

}  // namespace timsctl

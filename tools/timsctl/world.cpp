// timsctl world: shows and changes the true state of a simulated world. The commands are ordinary
// messages (`timsctl msg types World`) in a shorter form.
#include "rack/proxies/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"
#include "tools/timsctl/message.h"
#include "tools/timsctl/world.h"

namespace timsctl {
namespace {

constexpr Column kThings[] = {
    {"WHAT", "kind"},
    {"NAME", "name"},
    {"X mm", "x_mm"},
    {"Y mm", "y_mm"},
    {"RHO deg", "rho_deg"},
    {"VX mm/s", "vx_mm_s"},
    {"VY mm/s", "vy_mm_s", Cell::kText, true},
    {"OMEGA deg/s", "omega_deg_s", Cell::kText, true},
    {"TRAVELLED mm", "travelled_mm"},
    {"CONTACTS", "contacts", Cell::kCount, false, true},
    {"BUMPED", "bumped", Cell::kCount, true},
    {"BLOCKED", "blocked", Cell::kText, true},
    {"RADIUS mm", "radius_mm", Cell::kText, true},
    {"UNPLUGGED", "unplugged"},
};

std::int64_t degrees(double radians) { return std::llround(radians * 180 / std::numbers::pi); }

std::string_view kind_name(rack::i32 kind) {
  switch (kind) {
    case rack::world_thing::kRobot:
      return "robot";
    case rack::world_thing::kPerson:
      return "person";
    default:
      return "obstacle";
  }
}

json::object thing_json(const rack::WorldThing& thing) {
  json::object item{{"kind", kind_name(thing.kind)},
                    {"id", thing.id},
                    {"name", thing.name.view().empty() ? std::to_string(thing.id)
                                                       : std::string(thing.name.view())},
                    {"x_mm", thing.pos.x.raw()},
                    {"y_mm", thing.pos.y.raw()},
                    {"rho_rad", static_cast<double>(thing.pos.rho.raw())},
                    {"rho_deg", degrees(static_cast<double>(thing.pos.rho.raw()))}};
  if (thing.kind == rack::world_thing::kObstacle) {
    item["radius_mm"] = thing.radius.raw();
    return item;
  }
  item["vx_mm_s"] = thing.vx.raw();
  item["vy_mm_s"] = thing.vy.raw();
  if (thing.kind == rack::world_thing::kPerson) return item;
  item["omega_rad_s"] = static_cast<double>(thing.omega.raw());
  item["omega_deg_s"] = degrees(static_cast<double>(thing.omega.raw()));
  item["travelled_mm"] = thing.travelled.raw();
  item["contacts"] = thing.contacts();
  item["bumped"] = thing.bumped;
  item["blocked"] = thing.isBlocked != 0;
  return item;
}

// The unplugged devices of a robot.
std::string unplugged(const rack::WorldLines& lines, std::string_view robot) {
  std::string names;
  for (const rack::WorldLine& line : lines.lines)
    if (line.robot.view() == robot && line.isPlugged == 0)
      names += (names.empty() ? "" : " ") + std::string(line.sensor.view());
  return names;
}

json::array lines_json(const rack::WorldLines& lines) {
  json::array all;
  for (const rack::WorldLine& line : lines.lines)
    all.push_back({{"robot", line.robot.view()},
                   {"sensor", line.sensor.view()},
                   {"device", line.device.view()},
                   {"line", line.line.view()},
                   {"plugged", line.isPlugged != 0}});
  return all;
}

rack::WorldLines ask_lines(ComponentClient& client, tims::Address world) {
  const Message answer = client.ask(world, rack::WorldType::kGetLines);
  if (answer.header.type != rack::WorldType::kLines)
    throw Failure(Exit::kNo, "world_off", client.name_of(world) + " does not report its devices",
                  "is it on? timsctl component on " + client.name_of(world));
  return value_or_fail(rack::decode<rack::WorldLines>(answer.view()), client.name_of(world));
}

json::object ask_truth(ComponentClient& client, tims::Address world) {
  const auto newest = client.newest_data(world);
  if (!newest)
    throw Failure(Exit::kNo, "world_off", client.name_of(world) + " is off",
                  "timsctl component on " + client.name_of(world));
  const auto truth =
      value_or_fail(rack::decode<rack::WorldData>(newest->view()), client.name_of(world));
  const rack::WorldLines lines = ask_lines(client, world);
  json::array items;
  for (const rack::WorldThing& thing : truth.things) {
    json::object item = thing_json(thing);
    const std::string without = unplugged(lines, thing.name.view());
    if (thing.kind == rack::world_thing::kRobot && !without.empty()) item["unplugged"] = without;
    items.push_back(std::move(item));
  }
  return {{"schema", "tims/world/1"},
          {"world", address_json(world, client.widths())},
          {"recording_time_ms", truth.recordingTime.raw()},
          {"people_move", truth.peopleMove != 0},
          {"items", std::move(items)},
          {"lines", lines_json(lines)}};
}

// Sends a command to the world; the arguments are the fields of its message.
Message order(Context& context, std::string_view name, const std::vector<std::string>& fields) {
  ComponentClient client(context);
  const tims::Address world = find_world(context);
  const rack::MessageInfo& message = need_message(rack::kWorld, std::string(name));
  const auto body = make_body(message, rack::kWorld, fields,
                              {.widths = client.widths(), .si = context.options.si});
  Message answer = client.ask(world, message.type, std::span<const std::byte>(body));
  if (answer.header.type == tims::type::kError)
    need_ok(answer, client.name_of(world) + " refuses the command",
            "`timsctl world` shows its robots and devices");
  return answer;
}

Exit done(Context& context, json::object more, const std::string& text) {
  more["schema"] = "tims/world_changed/1";
  context.out.write(more, [&] { return text + "\n"; });
  return Exit::kDone;
}

Exit plug(Context& context, bool is_plugged) {
  const auto& arguments = context.options.arguments;
  (void)order(context, "PLUG",
              {"robot=" + arguments[0], "sensor=" + arguments[1],
               std::string("isPlugged=") + (is_plugged ? "1" : "0")});
  return done(
      context, {{"robot", arguments[0]}, {"sensor", arguments[1]}, {"plugged", is_plugged}},
      arguments[0] + "/" + arguments[1] + (is_plugged ? " is plugged in" : " is unplugged"));
}

}  // namespace

tims::Address find_world(Context& context) {
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  if (!context.options.world.empty()) return need_address(context.options.world, admin.widths());
  std::vector<tims::Address> worlds;
  const json::object answer = admin.ask({{"ask", "routes"}});
  for (const json::object& item : objects(items_of(answer))) {
    const auto address = parse_address(text_at(item, "address.raw"));
    if (!address) continue;
    const auto fields = address->fields(admin.widths());
    if (fields.class_id == rack::kWorld && fields.local == 0) worlds.push_back(*address);
  }
  if (worlds.empty())
    throw Failure(
        Exit::kNoSuch, "no_world", "this router knows no World",
        "start one with World --file=deploy/worlds/floor.toml, or use another router with -H");
  if (worlds.size() > 1)
    throw usage_error(fmt::format("there are {} worlds; name one", worlds.size()),
                      "--world " + shell_name(worlds.front(), admin.widths()));
  return worlds.front();
}

std::vector<std::pair<std::string, std::string>> world_devices(Context& context) {
  ComponentClient client(context);
  std::vector<std::pair<std::string, std::string>> all;
  for (const rack::WorldLine& line : ask_lines(client, find_world(context)).lines)
    all.emplace_back(line.robot.view(), line.sensor.view());
  return all;
}

Exit world_show(Context& context) {
  ComponentClient client(context, {.address = {}, .body_max = context.options.body_max_bytes});
  const tims::Address world = find_world(context);
  const auto ask = [&](AdminClient&) {
    json::object answer = ask_truth(client, world);
    const std::string& by = context.options.sort;
    if (!by.empty()) sort_items(item_array(answer), kThings, by);
    return answer;
  };
  return show(context, ask, table_of(kThings));
}

Exit world_place(Context& context) {
  const auto& arguments = context.options.arguments;
  (void)order(context, "PLACE",
              {"robot=" + arguments[0], "pos.x=" + arguments[1], "pos.y=" + arguments[2],
               "pos.rho=" + (arguments.size() > 3 ? arguments[3] : std::string("0"))});
  return done(context, {{"robot", arguments[0]}}, arguments[0] + " is at its new pose");
}

Exit world_put(Context& context) {
  const auto& arguments = context.options.arguments;
  const Message answer = order(
      context, "PUT", {"pos.x=" + arguments[0], "pos.y=" + arguments[1], "radius=" + arguments[2]});
  const auto there = value_or_fail(rack::decode<rack::WorldObstacle>(answer.view()), "World");
  return done(context, {{"id", there.id}}, std::to_string(there.id));
}

Exit world_remove(Context& context) {
  const auto& arguments = context.options.arguments;
  (void)order(context, "REMOVE", {"id=" + arguments[0]});
  return done(context, {{"id", arguments[0]}}, arguments[0] + " is removed");
}

Exit world_people(Context& context) {
  const std::string& state = context.options.arguments[0];
  if (state != "on" && state != "off")
    throw usage_error("world people: \"" + state + "\" is neither on nor off",
                      "on: people walk, off: they stand still");
  const bool move = state == "on";
  (void)order(context, "PEOPLE", {std::string("move=") + (move ? "1" : "0")});
  return done(context, {{"people_move", move}}, move ? "people walk" : "people stand still");
}

Exit world_unplug(Context& context) { return plug(context, false); }
Exit world_plug(Context& context) { return plug(context, true); }

}  // namespace timsctl

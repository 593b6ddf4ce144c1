// timsctl component pilot: who may drive a chassis.
#include <fmt/format.h>

#include "proxies/chassis.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/component_call.h"
#include "tools/timsctl/message_text.h"

namespace timsctl {

namespace {

// An address of anything else would take the chassis away from its pilots.
void need_class_of(tims::Address address, std::uint32_t wanted, std::string_view what,
                   std::string_view example, const tims::AddressWidths& widths) {
  if (address.fields(widths).class_id == wanted) return;
  throw usage_error(fmt::format("{} is no {}", address.to_string(widths), what),
                    fmt::format("such as {}", example));
}

void set_pilot(ComponentCall& call, tims::Address chassis, tims::Address pilot) {
  if (call.ask(chassis, tims::type::kGetStatus).header.type != tims::type::kEnabled)
    throw Failure(Exit::kNo, "component_off",
                  call.name_of(chassis) + " is not on, and forgets its pilot when it is turned on",
                  "`timsctl component on ADDR` first");
  const auto type = static_cast<std::int8_t>(rack::ChassisType::kSetActivePilot);
  need_ok(call.ask(chassis, type, rack::ChassisSetActivePilotData{pilot}),
          call.name_of(chassis) + " does not take it", "is it a chassis?");
}

std::optional<tims::Address> get_pilot(ComponentCall& call, tims::Address chassis) {
  const auto newest = call.newest_data(chassis);
  if (!newest)
    throw Failure(Exit::kNo, "no_data", call.name_of(chassis) + " has no data",
                  "it tells its pilot while it is on: `timsctl component on ADDR`");
  const auto data =
      value_or_fail(rack::decode<rack::ChassisData>(newest->view()), call.name_of(chassis));
  const tims::Address pilot = data.activePilot;
  return pilot == rack::kNoPilot ? std::nullopt : std::optional(pilot);
}

}  // namespace

Exit component_pilot(Context& context) {
  const auto& arguments = context.options.arguments;
  const auto connection = context.connect();
  const auto widths = connection->widths();
  ComponentCall call(context, *connection);
  const tims::Address chassis = need_address(arguments[0], widths);
  need_class_of(chassis, tims::class_id::kChassis, "chassis", "Chassis/0/0", widths);
  std::optional<tims::Address> pilot;
  if (arguments.size() > 1) {
    if (arguments[1] != "none") {
      pilot = need_address(arguments[1], widths);
      need_class_of(*pilot, tims::class_id::kPilot, "pilot", "Pilot/0/1, or none", widths);
    }
    waited(context, [&] { return set_pilot(call, chassis, pilot.value_or(rack::kNoPilot)), true; });
  } else {
    waited(context, [&] { return pilot = get_pilot(call, chassis), true; });
  }
  if (context.out.json()) {
    context.out.write(
        json::object{{"schema", "tims/active_pilot/1"},
                     {"chassis", address_json(chassis, widths)},
                     {"pilot", pilot ? json::value(address_json(*pilot, widths)) : nullptr}});
  } else {
    context.out.write((pilot ? call.name_of(*pilot) : std::string("none")) + "\n");
  }
  return Exit::kDone;
}

}  // namespace timsctl

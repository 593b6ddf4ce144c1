// timsctl sim fault --link: a bad network by the router's own hand, outside of a fleet in a box.
#include <fmt/format.h>

#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/sim/rules.h"

namespace timsctl {

namespace {

constexpr std::string_view kAll = "all";

sim::Quality need_quality(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "cut") throw usage_error("a router has no cable to pull", "blackout loses all");
    if (word.starts_with("direction="))
      throw usage_error("a router spoils what it sends, and nothing else",
                        "ask the router at the other end for the other direction");
  }
  const auto state = sim::changed({}, {}, words, sim::built_in_profiles());
  if (!state) throw usage_error(state.error().detail());
  return state->up;
}

}  // namespace

Exit link_fault(Context& context) {
  const sim::Quality quality = need_quality(context.options.arguments);
  const std::string& name = context.options.link;
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer = admin.ask(sim::all_faults(name == kAll ? "" : name, quality));
  if (context.out.json())
    context.out.write(answer);
  else
    context.out.note(fmt::format("{}, on the way out to {}: {}", text_at(answer, "router"),
                                 name == kAll ? "everybody" : name, sim::to_string(quality)));
  return Exit::kDone;
}

}  // namespace timsctl

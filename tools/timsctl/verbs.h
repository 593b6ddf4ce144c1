// The one table of verbs. Parsing, --help, completion and the README are made from it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/failure.h"
#include "tools/cli/options.h"

namespace timsctl {

class Context;

std::span<const Verb> verbs();

// What the first words name. Unique prefixes are enough; `route` alone is `route show`.
struct Resolved {
  const Verb* verb = nullptr;  // nullptr: only a noun, or nothing
  std::string_view noun;       // empty: nothing
  std::size_t words = 0;       // how many of the words it took
};
// Throws Failure for words that name nothing, or more than one thing.
Resolved resolve(std::span<const std::string> words);

// --- What the table runs. One file a noun; those of robots and fleets are other programs

Exit status(Context& context);

Exit router_show(Context& context);
Exit router_clients(Context& context);
Exit router_list(Context& context);

Exit link_show(Context& context);
Exit link_up(Context& context);
Exit link_down(Context& context);
Exit link_reset(Context& context);

Exit fleet_show(Context& context);
Exit fleet_server(Context& context);

Exit route_show(Context& context);
Exit route_get(Context& context);
Exit route_watch(Context& context);
Exit route_add(Context& context);
Exit route_del(Context& context);

Exit mbx_list(Context& context);
Exit mbx_show(Context& context);

Exit component_list(Context& context);
Exit component_status(Context& context);
Exit component_show(Context& context);
Exit component_on(Context& context);
Exit component_off(Context& context);
Exit component_param(Context& context);
Exit component_data(Context& context);
Exit component_pilot(Context& context);

Exit log_show(Context& context);
Exit log_follow(Context& context);

Exit ping(Context& context);
Exit explain(Context& context);
Exit trace(Context& context);
Exit clock(Context& context);

Exit msg_pub(Context& context);
Exit msg_echo(Context& context);
Exit msg_hz(Context& context);
Exit msg_bw(Context& context);
Exit msg_types(Context& context);
Exit msg_show(Context& context);

Exit top(Context& context);
Exit stats(Context& context);

Exit config_check(Context& context);
Exit config_show(Context& context);

Exit doctor(Context& context);
Exit completion(Context& context);
Exit complete(Context& context);
Exit errors(Context& context);

}  // namespace timsctl

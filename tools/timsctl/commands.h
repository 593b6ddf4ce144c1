// What the table of verbs runs. One file a noun.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "tools/timsctl/exit_code.h"

namespace timsctl {

class Context;

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

Exit up(Context& context);
Exit down(Context& context);
Exit robot_show(Context& context);
Exit save_parameters(Context& context);  // component param save

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

Exit sim_up(Context& context);
Exit sim_down(Context& context);
Exit sim_show(Context& context);
Exit sim_fault(Context& context);
Exit link_fault(Context& context);  // with --link
Exit sim_kill(Context& context);
Exit sim_start(Context& context);
Exit sim_exec(Context& context);
// What may stand in the place of that argument, for completion.
std::vector<std::string> sim_candidates(std::string_view verb, std::size_t argument);

Exit doctor(Context& context);
Exit completion(Context& context);
Exit complete(Context& context);
Exit errors(Context& context);

}  // namespace timsctl

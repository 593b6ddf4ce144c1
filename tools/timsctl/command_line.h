// The table of verbs: parsing, --help, completion and the manual pages use it.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tools/cli/failure.h"
#include "tools/cli/options.h"
#include "tools/cli/program.h"

namespace timsctl {

class Context;

std::span<const Verb> verbs();

// The verb that the first arguments name. Unique prefixes suffice; `route` alone is `route show`,
// nothing at all is `status`: subcommands of CLI11 have neither. Throws Failure if the arguments
// name no verb or are ambiguous.
Resolved resolve(std::span<const std::string> arguments);

const Program& timsctl_program();

// --- Functions of the table, one file per noun. Verbs of robots and fleets are other programs

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

Exit acl_show(Context& context);
Exit acl_hits(Context& context);
Exit acl_test(Context& context);
Exit acl_log(Context& context);

Exit mbx_list(Context& context);
Exit mbx_show(Context& context);

Exit component_list(Context& context);
Exit component_status(Context& context);
Exit component_describe(Context& context);
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
Exit config_migrate(Context& context);
Exit config_diff(Context& context);
Exit config_apply(Context& context);
Exit config_confirm(Context& context);
Exit config_undo(Context& context);
Exit config_history(Context& context);
Exit config_budget(Context& context);

Exit tunnel(Context& context);
Exit web(Context& context);
Exit key_init(Context& context);
Exit key_list(Context& context);
Exit key_show(Context& context);
Exit key_ca(Context& context);
Exit key_request(Context& context);
Exit key_sign(Context& context);
Exit key_import(Context& context);
Exit key_renew(Context& context);
Exit key_revoke(Context& context);
Exit key_rotate(Context& context);
Exit key_serve(Context& context);

Exit token_new(Context& context);
Exit token_list(Context& context);
Exit token_revoke(Context& context);

Exit join(Context& context);

Exit device_list(Context& context);
Exit device_watch(Context& context);
Exit device_record(Context& context);
Exit device_play(Context& context);

Exit camera_save(Context& context);

Exit world_show(Context& context);
Exit world_place(Context& context);
Exit world_put(Context& context);
Exit world_remove(Context& context);
Exit world_people(Context& context);
Exit world_unplug(Context& context);
Exit world_plug(Context& context);

Exit nav_where(Context& context);
Exit nav_goto(Context& context);
Exit nav_path(Context& context);
Exit nav_map(Context& context);
Exit nav_plot(Context& context);

Exit doctor(Context& context);
Exit completion(Context& context);
Exit complete(Context& context);
Exit errors(Context& context);

// Replaces this process by the program of the verb: same terminal, process id and exit status.
[[noreturn]] void become_verb(std::string_view program, const std::string& verb,
                              const Options& options, std::span<const std::string> arguments);

}  // namespace timsctl

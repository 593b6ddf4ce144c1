// The table of verbs and the parser of the command line. Parsing, --help, completion and the manual
// pages use the table.
//
// The other programs use CLI11, which does not support what timsctl needs: unique prefixes of nouns
// and verbs ("timsctl mb li"), negative numbers as arguments ("-6"), an omitted `show`, options
// with an optional value that never take the next argument, and suggestions in error messages.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/cli/failure.h"
#include "tools/cli/options.h"
#include "tools/cli/program.h"

namespace timsctl {

class Context;

std::span<const Verb> verbs();

// The verb that the first arguments name. Unique prefixes suffice; `route` alone is `route show`.
struct Resolved {
  const Verb* verb = nullptr;  // nullptr: only a noun was given, or nothing
  std::string_view noun;       // empty: nothing was given
  std::size_t used = 0;        // number of arguments that name the verb
};
// Throws Failure if the arguments name no verb or are ambiguous.
Resolved resolve(std::span<const std::string> arguments);

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

// `arguments` does not contain the program name. Throws Failure if the command line is wrong.
std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments);

// Replaces this process by the program of the verb: same terminal, process id and exit status.
[[noreturn]] void become_verb(std::string_view program, const std::string& verb,
                              const Options& options, std::span<const std::string> arguments);

// The command line split into arguments and options, before the verb is known.

struct SplitLine {
  std::vector<std::string> arguments;  // noun, verb, arguments; also "-" and numbers such as "-6"
  std::vector<std::string> options;    // in long form: "--count=5", "--json"
};

// Throws Failure for an unknown option and for a missing value.
SplitLine split_line(std::span<const std::string> arguments);

// Help texts, generated from the table of verbs.

std::string version_text();
std::string overview();
std::string noun_help(std::string_view noun);
bool is_single(std::string_view noun);  // a command without verbs: "ping"

}  // namespace timsctl

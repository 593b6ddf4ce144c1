// The table of verbs, and from argv to a verb and its options. Parsing, --help, completion, the
// manual pages and the README are made from the table.
//
// By hand, and not by CLI11 as in the other programs: unique beginnings of nouns and verbs are
// enough ("timsctl mb li"), "-6" is an argument, `show` may be left out, options whose value may be
// left out take none from the next word, and an error names what was meant.
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

Exit device_list(Context& context);
Exit device_watch(Context& context);
Exit device_record(Context& context);
Exit device_play(Context& context);

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

// Without the program's name. Throws Failure when the command line is wrong.
std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments);

// The program that does the verb, in place of this one: same terminal, process and exit status.
[[noreturn]] void become_verb(std::string_view program, const std::string& verb,
                              const Options& options, std::span<const std::string> arguments);

// The command line taken apart before anything is known about the verb: words and options.

struct Words {
  std::vector<std::string> words;    // noun, verb, arguments; also "-" and numbers such as "-6"
  std::vector<std::string> options;  // in one form: "--count=5", "--json"
};

// Throws Failure for options nobody has, and for a value that is missing.
Words split_words(std::span<const std::string> arguments);

// Texts made from the table of verbs.

std::string version_text();
std::string overview();
std::string noun_help(std::string_view noun);
bool is_single(std::string_view noun);  // a command without verbs: "ping"

}  // namespace timsctl

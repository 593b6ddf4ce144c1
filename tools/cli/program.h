// What is around the verbs of timsctl and of the programs that it becomes (timsctl-robot,
// timsctl-sim): from argv to a verb with its options, then the verb, and what went wrong as text or
// JSON and as an exit status.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/cli/context.h"
#include "tools/cli/options.h"

namespace timsctl {

using RunVerb = Exit (*)(Context& context);

struct Command {
  const Verb* verb = nullptr;
  RunVerb run = nullptr;
  Options options;
};
struct Text {  // --help, --version: print it, and that was all
  std::string text;
};
using Arguments = std::span<const std::string>;  // without the program's name
// Throws Failure when the command line is wrong.
using ParseCommandLine = std::function<std::variant<Command, Text>(Arguments arguments)>;

// The exit status of main().
int run_program(int argc, char** argv, const ParseCommandLine& parse);

// A program that timsctl becomes for some of its verbs, and that may be called by itself too.
struct VerbRun {
  std::string_view word;  // of a row of program_verbs()
  RunVerb run;
};
struct VerbProgram {
  std::string_view name;   // "timsctl-sim"
  std::string_view about;  // what it is for
  std::span<const VerbRun> runs;
  // What may stand in the place of that argument of a verb: asked by timsctl, for completion.
  std::vector<std::string> (*candidates)(std::string_view verb, std::size_t argument);
};
// Its command line is a verb, then general options, those of the verb, and arguments.
int run_program(int argc, char** argv, const VerbProgram& program);

// Texts of --help, made from the tables. `call`: "route show", "timsctl route show".
std::string option_lines(std::string_view names);
std::string verb_line(std::string_view call, const Verb& verb);
std::string verb_help(std::string_view call, const Verb& verb);
inline constexpr std::string_view kExitHelp =
    "Exit status: 0 done, 1 no or failed, 2 wrong command line, 3 no router, 4 no such thing,\n"
    "5 denied, 6 no answer in time or only a part, 7 other protocol version, 130 interrupted.\n";

// Throws Failure when a verb has too few or too many. `call`: "route show".
void check_arguments(std::string_view program, std::string_view call, const Verb& verb,
                     const std::vector<std::string>& arguments);

std::string_view own_version();
// Whether the list of words has this one.
bool is_in(std::string_view word, std::string_view list);

}  // namespace timsctl

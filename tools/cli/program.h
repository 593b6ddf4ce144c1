// The frame around the verbs of timsctl and of the programs that it executes (timsctl-robot,
// timsctl-sim): parses argv into a verb and its options, runs the verb, and reports a failure as
// text or JSON and as an exit status.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/cli/argument_parser.h"
#include "tools/cli/context.h"
#include "tools/cli/options.h"

namespace timsctl {

using RunVerb = Exit (*)(Context& context);

struct Command {
  const Verb* verb = nullptr;
  RunVerb run = nullptr;
  Options options;
};
struct Text {  // of --help or --version: it is printed, nothing is run
  std::string text;
};
using Arguments = std::span<const std::string>;  // without the program name

// The verb that the first arguments name.
struct Resolved {
  const Verb* verb = nullptr;  // nullptr: only a noun was given
  std::string_view noun{};
  std::size_t used = 0;  // number of arguments that name the verb
};

// A program with verbs.
struct Program {
  std::string_view name;                       // "timsctl"
  std::string (Verb::*call)() const;           // how a verb is called: "route show", "show"
  std::function<Resolved(Arguments)> resolve;  // throws Failure if there is no such verb
  std::function<RunVerb(const Verb&)> run;     // the function of the verb
  std::function<std::string(Arguments)> help;  // of --help with these arguments
};

// Returns the exit status.
int run_program(int argc, char** argv, const Program& program);

// The line of a program, with options anywhere.
Line split_line(const Program& program, Arguments arguments);
// Throws Failure if the command line is wrong.
std::variant<Command, Text> parse_line(const Program& program, const Line& line);

// A program that timsctl executes for some of its verbs; it can also be called directly.
struct VerbRun {
  std::string_view verb;  // Verb::short_name() of a row of program_verbs()
  RunVerb run;
};
struct VerbProgram {
  std::string_view name;   // "timsctl-sim"
  std::string_view about;  // its purpose
  std::span<const VerbRun> runs;
  // The possible values of an argument of a verb, for the completion of timsctl.
  std::vector<std::string> (*candidates)(std::string_view verb, std::size_t argument);
};
int run_program(int argc, char** argv, const VerbProgram& program);

// Help texts, generated from the tables: CLI11 does not wrap lines, and would list the options of
// all verbs. `call`: "route show", "timsctl route show".
std::string option_lines(std::string_view names);
std::string verb_line(std::string_view call, const Verb& verb);
std::string verb_help(std::string_view call, const Verb& verb);
inline constexpr std::string_view kExitHelp =
    "Exit status: 0 done, 1 no or failed, 2 wrong command line, 3 no router, 4 not found,\n"
    "5 denied, 6 no answer in time or only a part, 7 other protocol version, 130 interrupted.\n";

std::string_view own_version();
bool has_option(const Verb& verb, const OptionRow& option);

}  // namespace timsctl

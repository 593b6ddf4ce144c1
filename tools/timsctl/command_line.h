// From argv to a verb and its options, and the texts of --help.
//
// By hand, and not by CLI11 as in the other programs: unique beginnings of nouns and verbs are
// enough ("timsctl mb li"), "-6" is an argument, `show` may be left out, options whose value may be
// left out take none from the next word, and an error names what was meant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/cli/program.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

// Without the program's name. Throws Failure when the command line is wrong.
std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments);

// The program that does the verb, in place of this one: same terminal, process and exit status.
[[noreturn]] void become_verb(const Verb& verb, const Options& options,
                              std::span<const std::string> arguments);

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
std::string verb_help(const Verb& verb);
bool is_single(std::string_view noun);  // a command without verbs: "ping"

}  // namespace timsctl

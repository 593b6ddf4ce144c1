#include "tools/cli/program.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "base/text.h"
#include "proxies/message_files.h"
#include "tims/session.h"
#include "tools/cli/argument_parser.h"

#ifndef TIMS_VERSION
#error "TIMS_VERSION must be defined by the build"
#endif

namespace timsctl {

namespace {

bool no_color() {
  const char* asked = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  return (asked != nullptr && *asked != 0) || term == nullptr || std::string_view(term) == "dumb";
}

// -H, else $TIMS_HOST, else the default router of this host.
Host router_of(const Options& options) {
  if (!options.host.empty()) return parse_host(options.host);
  const char* host = std::getenv("TIMS_HOST");
  if (host != nullptr && *host != 0) return parse_host(host);
  return parse_host(tims::default_router());
}

// Errors of the command line are reported as JSON, too, if it requests JSON.
Options for_errors(Arguments arguments) {
  Options options;
  std::string_view before;
  for (const std::string& argument : arguments) {
    const bool short_form =
        argument == "-j" || argument == "-ojson" || (before == "-o" && argument == "json");
    if (short_form || argument == "--json" || argument == "--json-lines" ||
        argument == "--output=json")
      options.format = Format::kJson;
    before = argument;
  }
  return options;
}

Exit run(const Command& command, Output& out, const Signals& signals) {
  Context context(*command.verb, command.options, out, signals, router_of(command.options));
  try {
    return command.run(context);
  } catch (const Interrupted&) {
    // For a continuous verb, Ctrl-C is the normal end.
    return command.verb->endless && command.options.endless() ? Exit::kDone : Exit::kInterrupted;
  }
}

Exit run(Arguments arguments, const ParseCommandLine& parse) {
  const Signals signals;  // before any thread
  Output out(for_errors(arguments), true);
  const auto problems = rack::load_message_files();
  try {
    const auto parsed = parse(arguments);
    if (const auto* text = std::get_if<Text>(&parsed)) {
      out.write(text->text);
      return Exit::kDone;
    }
    const auto& command = std::get<Command>(parsed);
    out = Output(command.options, no_color());
    for (const std::string& problem : problems) out.note(problem);
    return run(command, out, signals);
  } catch (const Failure& failure) {
    out.failure(failure);
    return failure.exit;
  } catch (const Interrupted&) {
    return Exit::kInterrupted;
  } catch (const std::exception& error) {
    out.failure({Exit::kVersion, "unexpected_answer", error.what(),
                 "the answer of the router has an unexpected form: does it have another version?"});
    return Exit::kVersion;
  }
}

// Options after the first argument of such a verb belong to the command that it runs.
bool takes_a_command(const Verb& verb) { return verb.arguments.ends_with("COMMAND..."); }

using Verbs = std::vector<const Verb*>;

std::string program_help(const VerbProgram& program, const Verbs& verbs) {
  std::string text =
      fmt::format("{} VERB [ARGUMENTS] [OPTIONS]: {}\n\n", program.name, program.about);
  for (const Verb* verb : verbs) text += verb_line(verb->short_name(), *verb);
  return text + fmt::format("\nGeneral options:\n{}More: {} VERB --help\n\n{}",
                            option_lines(kGeneralOptions), program.name, kExitHelp);
}

// The verb that the first of these arguments names.
const Verb& find_verb(const VerbProgram& program, const Verbs& verbs, Arguments arguments) {
  std::vector<std::string> known;
  for (const Verb* verb : verbs) known.push_back(verb->short_name());
  const std::string all =
      fmt::format("known: {}; see `{} --help`", fmt::join(known, ", "), program.name);
  if (arguments.empty()) throw usage_error("the verb is missing", all);
  const std::string& given = arguments.front();
  if (given.starts_with('-'))
    throw usage_error(fmt::format("{}: options must follow the verb", given), all);
  const auto found = std::ranges::find(verbs, given, &Verb::short_name);
  if (found != verbs.end()) return **found;
  throw usage_error(
      fmt::format("no verb \"{}\"", given),
      nearest_hint(given, std::vector<std::string_view>(known.begin(), known.end()), all));
}

void add_options(ArgumentParser& parser, const Verb& verb, Options& options) {
  for (const OptionRow& row : option_table()) {
    if (!is_in(row.name, kGeneralOptions) && !is_in(row.name, verb.options)) continue;
    std::string names = fmt::format("--{}", row.name);
    if (row.letter != 0) names += fmt::format(",-{}", row.letter);
    const auto set = [&row, &options](const std::string& value) { row.apply(options, value); };
    if (row.value.empty())
      parser.flag(names, [set] { set({}); });
    else
      parser.option(names, row.value, set);
  }
}

std::string lines_of(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& value : values) text += value + "\n";
  return text;
}

// Wraps the text at blanks; all lines except the first are indented.
std::string wrapped(std::string_view text, std::size_t indent) {
  constexpr std::size_t kWidth = 98;
  std::string out;
  while (indent + text.size() > kWidth) {
    const std::size_t blank = text.rfind(' ', kWidth - indent);
    if (blank == std::string_view::npos) break;
    out.append(text.substr(0, blank)).append("\n").append(indent, ' ');
    text.remove_prefix(blank + 1);
  }
  return out.append(text).append("\n");
}

// "  -n, --count N               stop after N"
std::string help_line(const std::string& what, std::string_view text) {
  constexpr std::size_t kIndent = 32;
  const bool fits = what.size() < kIndent - 2;
  return fmt::format("  {:<29}{}{}", what, fits ? " " : "\n" + std::string(kIndent, ' '),
                     wrapped(text, kIndent));
}

std::variant<Command, Text> parse_verb_program(const VerbProgram& program, Arguments arguments) {
  if (arguments.size() == 3 && arguments[0] == "__complete")
    return Text{lines_of(program.candidates(
        arguments[1], base::parse_number<std::size_t>(arguments[2]).value_or(0)))};
  // Everything after "--" is an argument.
  const auto mark = std::ranges::find(arguments, "--");
  const std::span before(arguments.begin(), mark);
  const std::span behind(mark == arguments.end() ? mark : mark + 1, arguments.end());
  const Text version{fmt::format("{} {}\n", program.name, own_version())};
  Verbs verbs;
  for (const Verb& verb : program_verbs())
    if (verb.program == program.name) verbs.push_back(&verb);
  const std::string first = before.empty() ? "" : before.front();
  if (first == "-h" || first == "--help") return Text{program_help(program, verbs)};
  if (first == "--version") return version;
  const Verb& verb = find_verb(program, verbs, before);
  const std::string call = fmt::format("{} {}", program.name, verb.short_name());
  Options options;
  ArgumentParser parser(call);
  add_options(parser, verb, options);
  if (takes_a_command(verb))
    parser.command(options.arguments);
  else
    parser.arguments("arguments", options.arguments);
  switch (parser.parse(before.subspan(1))) {
    case ArgumentParser::Asked::kHelp:
      return Text{verb_help(call, verb)};
    case ArgumentParser::Asked::kVersion:
      return version;
    case ArgumentParser::Asked::kRun:
      break;
  }
  options.arguments.insert(options.arguments.end(), behind.begin(), behind.end());
  check_arguments(program.name, verb.short_name(), verb, options.arguments);
  const auto run = std::ranges::find(program.runs, verb.short_name(), &VerbRun::verb);
  return Command{&verb, run->run, std::move(options)};
}

}  // namespace

int run_program(int argc, char** argv, const ParseCommandLine& parse) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return static_cast<int>(run(arguments, parse));
}

int run_program(int argc, char** argv, const VerbProgram& program) {
  return run_program(argc, argv,
                     [&](Arguments arguments) { return parse_verb_program(program, arguments); });
}

std::string option_lines(std::string_view names) {
  std::string text;
  for (const OptionRow& row : option_table()) {
    if (!is_in(row.name, names)) continue;
    const std::string letter = row.letter != 0 ? fmt::format("-{}, ", row.letter) : "    ";
    const std::string value = row.value.empty() ? ""
                              : row.value.starts_with('[')
                                  ? fmt::format("[={}", row.value.substr(1))
                                  : fmt::format(" {}", row.value);
    text += help_line(fmt::format("{}--{}{}", letter, row.name, value), row.help);
  }
  return text;
}

std::string verb_line(std::string_view call, const Verb& verb) {
  const std::string what =
      fmt::format("{}{}{}", call, verb.arguments.empty() ? "" : " ", verb.arguments);
  return help_line(what, verb.help.substr(0, verb.help.find(". ")));
}

std::string verb_help(std::string_view call, const Verb& verb) {
  std::string text = fmt::format("{}{}{}\n\n{}", call, verb.arguments.empty() ? "" : " ",
                                 verb.arguments, wrapped(verb.help, 0));
  const std::string own = option_lines(verb.options);
  if (!own.empty()) text += "\nOptions:\n" + own;
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  return verb.example.empty() ? text : text + fmt::format("\nExample:\n  {}\n", verb.example);
}

void check_arguments(std::string_view program, std::string_view call, const Verb& verb,
                     const std::vector<std::string>& arguments) {
  const std::string usage = fmt::format("{} {} {}", program, call, verb.arguments);
  if (arguments.size() < verb.arguments_min)
    throw usage_error(fmt::format("{}: {} is missing", call, verb.arguments), usage);
  if (arguments.size() > verb.arguments_max)
    throw usage_error(
        fmt::format("{}: unexpected argument \"{}\"", call, arguments[verb.arguments_max]), usage);
}

std::string_view own_version() { return TIMS_VERSION; }

bool is_in(std::string_view element, std::string_view list) {
  return fmt::format(" {} ", list).find(fmt::format(" {} ", element)) != std::string::npos;
}

}  // namespace timsctl

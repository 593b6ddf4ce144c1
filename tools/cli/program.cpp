#include "tools/cli/program.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "base/text.h"
#include "proxies/message_files.h"
#include "tools/cli/arguments.h"

#ifndef TIMS_VERSION
#error "TIMS_VERSION must be defined by the build"
#endif

namespace timsctl {

namespace {

// NOLINTBEGIN(concurrency-mt-unsafe): the environment is never changed
bool no_color() {
  const char* asked = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  return (asked != nullptr && *asked != 0) || term == nullptr || std::string_view(term) == "dumb";
}

// Whether the blank-separated list contains this element.
bool is_in(std::string_view element, std::string_view list) {
  return std::ranges::count(parts_of(list, ' '), element) > 0;
}

// NOLINTEND(concurrency-mt-unsafe)

// Errors of the command line are reported as JSON, too, if it requests JSON.
Options for_errors(const Line& line) {
  Options options;
  for (const auto& [option, value] : line.options)
    if (option->name.starts_with("json") || (option->name == "output" && value == "json"))
      options.format = Format::kJson;
  return options;
}

Exit run(const Command& command, Output& out, const Signals& signals) {
  Context context(*command.verb, command.options, out, signals, host_of(command.options.host));
  try {
    return command.run(context);
  } catch (const Interrupted&) {
    // For a continuous verb, Ctrl-C is the normal end.
    return command.verb->endless && command.options.endless() ? Exit::kDone : Exit::kInterrupted;
  }
}

Exit run(Arguments arguments, const Program& program) {
  const Signals signals;  // before any thread
  const Line line = split_line(program, arguments);
  Output out(for_errors(line), true);
  const auto problems = rack::load_message_files();
  try {
    const auto parsed = parse_line(program, line);
    if (const auto* text = std::get_if<Text>(&parsed)) {
      out.write_pages(text->text);
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

using Verbs = std::vector<const Verb*>;

std::string program_help(const VerbProgram& program, const Verbs& verbs) {
  std::string text =
      fmt::format("{} VERB [ARGUMENTS] [OPTIONS]: {}\n\n", program.name, program.about);
  for (const Verb* verb : verbs) text += verb_line(verb->short_name(), *verb);
  return text + fmt::format("\nGeneral options:\n{}More: {} VERB --help\n\n{}",
                            option_lines(kGeneralOptions), program.name, kExitHelp);
}

Resolved find_verb(const VerbProgram& program, const Verbs& verbs, Arguments arguments) {
  std::vector<std::string> known;
  for (const Verb* verb : verbs) known.push_back(verb->short_name());
  const std::string all =
      fmt::format("known: {}; see `{} --help`", fmt::join(known, ", "), program.name);
  if (arguments.empty()) throw usage_error("the verb is missing", all);
  const std::string& given = arguments.front();
  const auto found = std::ranges::find(verbs, given, &Verb::short_name);
  if (found != verbs.end()) return {*found, (*found)->noun, 1};
  throw usage_error(
      fmt::format("no verb \"{}\"", given),
      nearest_hint(given, std::vector<std::string_view>(known.begin(), known.end()), all));
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

// "timsctl route get ADDR"
std::string usage_of(std::string_view call, const Verb& verb) {
  return fmt::format("{}{}{}", call, verb.arguments.empty() ? "" : " ", verb.arguments);
}

// Fills the options of a verb. Throws Failure if it does not have one of them.
class Applier {
 public:
  // `name`: "route get"; `call`: "timsctl route get".
  Applier(const Verb& verb, std::string name, std::string call)
      : verb_(verb), name_(std::move(name)), call_(std::move(call)) {}

  Options apply(const Line& line, Arguments arguments) const {
    if (!line.unknown.empty()) throw no_option(line.unknown);
    Options options;
    for (const auto& [option, value] : line.options) {
      const std::string name = fmt::format("--{}", option->name);
      if (!has_option(verb_, *option)) throw no_option(name);
      option->apply(options, value);
      options.given.push_back(option->value.empty() ? name : fmt::format("{}={}", name, value));
    }
    options.arguments.assign(arguments.begin(), arguments.end());
    check_arguments(arguments);
    check_form(options.format);
    return options;
  }

 private:
  // `option`: "--cuont=3", "-Z".
  [[nodiscard]] Failure no_option(std::string_view option) const {
    const bool is_long = option.starts_with("--");
    const std::string name(option.substr(0, is_long ? option.find('=') : 2));
    std::vector<std::string> known{"--help", "--version"};
    for (const OptionRow& row : option_table())
      if (has_option(verb_, row)) known.push_back(fmt::format("--{}", row.name));
    return usage_error(
        fmt::format("{} has no option {}", name_, name),
        nearest_hint(
            name, std::vector<std::string_view>(known.begin(), known.end()),
            fmt::format("`{} --help`{}", call_,
                        is_long ? "" : "; an argument that begins with - must follow --")));
  }

  void check_arguments(Arguments arguments) const {
    if (arguments.size() < verb_.arguments_min)
      throw usage_error(fmt::format("{}: {} is missing", name_, verb_.arguments),
                        usage_of(call_, verb_));
    if (arguments.size() > verb_.arguments_max)
      throw usage_error(
          fmt::format("{}: unexpected argument \"{}\"", name_, arguments[verb_.arguments_max]),
          usage_of(call_, verb_));
  }

  void check_form(Format format) const {
    if (is_in(form_name(format), verb_.forms)) return;
    throw usage_error(
        fmt::format("{} does not support -o {}", name_, form_name(format)),
        fmt::format("available forms: {}", fmt::join(parts_of(verb_.forms, ' '), ", ")));
  }

  const Verb& verb_;
  std::string name_;
  std::string call_;
};

}  // namespace

int run_program(int argc, char** argv, const Program& program) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return static_cast<int>(run(arguments, program));
}

int run_program(int argc, char** argv, const VerbProgram& program) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 3 && arguments[0] == "__complete") {
    try {
      const auto place = base::parse_number<std::size_t>(arguments[2]).value_or(0);
      for (const std::string& candidate : program.candidates(arguments[1], place))
        fmt::print("{}\n", candidate);
    } catch (const std::exception&) {  // no candidates
    }
    return static_cast<int>(Exit::kDone);
  }
  Verbs verbs;
  for (const Verb& verb : program_verbs())
    if (verb.program == program.name) verbs.push_back(&verb);
  const auto resolve = [&](Arguments line) { return find_verb(program, verbs, line); };
  const auto run = [&](const Verb& verb) {
    return std::ranges::find(program.runs, verb.short_name(), &VerbRun::verb)->run;
  };
  const auto help = [&](Arguments line) {
    if (line.empty()) return program_help(program, verbs);
    const Verb& verb = *resolve(line).verb;
    return verb_help(fmt::format("{} {}", program.name, verb.short_name()), verb);
  };
  return run_program(argc, argv, Program{program.name, &Verb::short_name, resolve, run, help});
}

Line split_line(const Program& program, Arguments arguments) {
  return split_line(arguments, [&](Arguments before) {
    try {
      const Resolved found = program.resolve(before);
      return found.verb != nullptr && found.verb->arguments.ends_with("COMMAND...") &&
             before.size() == found.used + found.verb->arguments_min;
    } catch (const Failure&) {
      return false;  // reported when all arguments are known
    }
  });
}

std::variant<Command, Text> parse_line(const Program& program, const Line& line) {
  if (line.version) return Text{fmt::format("{} {}\n", program.name, own_version())};
  const Arguments arguments(line.arguments);
  const bool asks_for_help = !arguments.empty() && arguments.front() == "help";
  if (asks_for_help || line.help)
    return Text{program.help(arguments.subspan(asks_for_help ? 1 : 0))};
  if (line.failure) throw Failure(*line.failure);
  const Resolved found = program.resolve(arguments);
  if (found.verb == nullptr)
    throw usage_error(fmt::format("{} {}: the verb is missing", program.name, found.noun),
                      fmt::format("{} {} --help", program.name, found.noun));
  const std::string name = (found.verb->*program.call)();
  const Applier applier(*found.verb, name, fmt::format("{} {}", program.name, name));
  return Command{found.verb, program.run(*found.verb),
                 applier.apply(line, arguments.subspan(found.used))};
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
  return help_line(usage_of(call, verb), verb.help.substr(0, verb.help.find(". ")));
}

std::string verb_help(std::string_view call, const Verb& verb) {
  std::string text = fmt::format("{}\n\n{}", usage_of(call, verb), wrapped(verb.help, 0));
  const std::string own = option_lines(verb.options);
  if (!own.empty()) text += "\nOptions:\n" + own;
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  return verb.example.empty() ? text : text + fmt::format("\nExample:\n  {}\n", verb.example);
}

std::string_view own_version() { return TIMS_VERSION; }

bool has_option(const Verb& verb, const OptionRow& option) {
  return is_in(option.name, verb.options) || is_in(option.name, kGeneralOptions);
}

}  // namespace timsctl

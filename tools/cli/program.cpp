#include "tools/cli/program.h"

#include <algorithm>
#include <cstdlib>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "base/text.h"
#include "proxies/message_files.h"
#include "tims/session.h"

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
  for (const std::string& word : arguments) {
    const bool short_form = word == "-j" || word == "-ojson" || (before == "-o" && word == "json");
    if (short_form || word == "--json" || word == "--json-lines" || word == "--output=json")
      options.format = Format::kJson;
    before = word;
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

bool has_option(const Verb& verb, std::string_view name) {
  return is_in(name, kGeneralOptions) || is_in(name, verb.options);
}

CLI::App& add_verb(CLI::App& app, const Verb& verb, Options& options) {
  CLI::App& own = *app.add_subcommand(verb.word());
  for (const OptionRow& row : option_table()) {
    if (!has_option(verb, row.name)) continue;
    std::string names = fmt::format("--{}", row.name);
    if (row.letter != 0) names += fmt::format(",-{}", row.letter);
    const auto set = [&row, &options](const std::string& value) { row.apply(options, value); };
    if (row.value.empty())
      own.add_flag_callback(names, [set] { set({}); });
    else
      own.add_option_function<std::string>(names, set)->type_name(std::string(row.value));
  }
  if (takes_a_command(verb))
    own.prefix_command();
  else
    own.add_option("arguments", options.arguments);
  return own;
}

using Verbs = std::vector<std::pair<const Verb*, CLI::App*>>;

std::string program_help(const VerbProgram& program, const Verbs& verbs) {
  std::string text =
      fmt::format("{} VERB [ARGUMENTS] [OPTIONS]: {}\n\n", program.name, program.about);
  for (const auto& [verb, app] : verbs) text += verb_line(verb->word(), *verb);
  return text + fmt::format("\nGeneral options:\n{}More: {} VERB --help\n\n{}",
                            option_lines(kGeneralOptions), program.name, kExitHelp);
}

std::vector<std::string_view> words_of(const Verbs& verbs) {
  std::vector<std::string_view> words;
  for (const auto& [verb, app] : verbs)
    words.push_back(verb->verb.empty() ? verb->noun : verb->verb);
  return words;
}

// CLI11 would report an unknown verb as a missing verb.
void check_verb(const VerbProgram& program, const Verbs& verbs,
                std::span<const std::string> arguments) {
  const auto known = words_of(verbs);
  const std::string all =
      fmt::format("known: {}; see `{} --help`", fmt::join(known, ", "), program.name);
  if (arguments.empty()) throw usage_error("the verb is missing", all);
  const std::string& word = arguments.front();
  if (word.starts_with("--help") || word == "-h" || word == "--version") return;
  if (word.starts_with('-'))
    throw usage_error(fmt::format("{}: options must follow the verb", word), all);
  if (std::ranges::find(known, word) == known.end())
    throw usage_error(fmt::format("no verb \"{}\"", word), nearest_hint(word, known, all));
}

// The failure for a command line that CLI11 has rejected.
Failure refused(const VerbProgram& program, const Verb& verb, const CLI::App& app,
                const CLI::ParseError& error) {
  const std::string help = fmt::format("`{} {} --help`", program.name, verb.word());
  const auto extra = app.remaining(true);
  if (extra.empty()) return usage_error(error.what(), help);
  std::vector<std::string> known;
  for (const OptionRow& row : option_table())
    if (has_option(verb, row.name)) known.push_back(fmt::format("--{}", row.name));
  const std::string name = extra.front().substr(0, extra.front().find('='));
  return usage_error(
      fmt::format("{} has no option {}", verb.word(), name),
      nearest_hint(name, std::vector<std::string_view>(known.begin(), known.end()), help));
}

std::string lines_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + "\n";
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
  // Everything after "--" is an argument. CLI11 would assign it to the program, not to the verb.
  const auto mark = std::ranges::find(arguments, "--");
  const std::span before(arguments.begin(), mark);
  const std::span behind(mark == arguments.end() ? mark : mark + 1, arguments.end());
  Options options;
  CLI::App app;
  app.set_version_flag("--version", fmt::format("{} {}", program.name, own_version()));
  Verbs verbs;
  for (const Verb& verb : program_verbs())
    if (verb.program == program.name) verbs.emplace_back(&verb, &add_verb(app, verb, options));
  check_verb(program, verbs, before);
  const auto parsed = [&] {
    return std::ranges::find_if(verbs, [](const auto& own) { return own.second->parsed(); });
  };
  try {
    std::vector<std::string> reversed(before.rbegin(), before.rend());
    app.parse(reversed);  // CLI11 expects the arguments in reverse order
  } catch (const CLI::CallForHelp&) {
    if (parsed() == verbs.end()) return Text{program_help(program, verbs)};
    const Verb& verb = *parsed()->first;
    return Text{verb_help(fmt::format("{} {}", program.name, verb.word()), verb)};
  } catch (const CLI::CallForVersion& version) {
    return Text{version.what() + std::string("\n")};
  } catch (const CLI::ParseError& error) {
    throw refused(program, *parsed()->first, app, error);
  }
  const auto& [verb, own] = *parsed();
  if (takes_a_command(*verb)) options.arguments = own->remaining();
  options.arguments.insert(options.arguments.end(), behind.begin(), behind.end());
  check_arguments(program.name, verb->word(), *verb, options.arguments);
  const auto run = std::ranges::find(program.runs, verb->word(), &VerbRun::word);
  return Command{verb, run->run, std::move(options)};
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

bool is_in(std::string_view word, std::string_view list) {
  return fmt::format(" {} ", list).find(fmt::format(" {} ", word)) != std::string::npos;
}

}  // namespace timsctl

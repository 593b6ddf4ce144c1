#include "tools/cli/program.h"

#include <algorithm>
#include <cstdlib>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "base/text.h"
#include "proxies/message_files.h"
#include "tims/session.h"

#ifndef TIMS_VERSION
#error "the build says which version this is"
#endif

namespace timsctl {

namespace {

bool no_color() {
  const char* asked = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  return (asked != nullptr && *asked != 0) || term == nullptr || std::string_view(term) == "dumb";
}

// -H, else $TIMS_HOST, else the router that programs of this host use.
Host router_of(const Options& options) {
  if (!options.host.empty()) return parse_host(options.host);
  const char* host = std::getenv("TIMS_HOST");
  if (host != nullptr && *host != 0) return parse_host(host);
  return parse_host(tims::default_router());
}

// Errors of the command line are answered as JSON too, when it asks for JSON.
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
    // A verb without an end of its own is done when it is stopped.
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
                 "the router's answer has another form than expected: another version?"});
    return Exit::kVersion;
  }
}

void add_option(CLI::App& app, const OptionRow& row, Options& options) {
  std::string names = fmt::format("--{}", row.name);
  if (row.letter != 0) names += fmt::format(",-{}", row.letter);
  const std::string help(row.help);
  const auto set = [&row, &options](const std::string& value) {
    try {
      row.set(options, value);
    } catch (const Failure& failure) {
      throw usage_error(fmt::format("--{}: {}", row.name, failure.message));
    }
  };
  if (row.value.empty())
    app.add_flag_callback(
        names, [set] { set({}); }, help);
  else
    app.add_option_function<std::string>(names, set, help)->type_name(std::string(row.value));
}

// Options behind the first argument of such a verb belong to the command that it runs.
bool takes_a_command(const Verb& verb) { return verb.arguments.ends_with("COMMAND..."); }

CLI::App& add_verb(CLI::App& app, const Verb& verb, Options& options) {
  CLI::App& own = *app.add_subcommand(verb.word(), std::string(verb.help));
  for (const OptionRow& row : option_table())
    if (is_in(row.name, kGeneralOptions) || is_in(row.name, verb.options))
      add_option(own, row, options);
  if (takes_a_command(verb)) {
    own.prefix_command();
  } else if (verb.arguments_max > 0) {
    own.add_option("arguments", options.arguments)
        ->type_name(std::string(verb.arguments))
        ->expected(0, static_cast<int>(verb.arguments_max));
  }
  return own;
}

std::string lines_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + "\n";
  return text;
}

// The first word is one of the program's verbs, or an option of its own: CLI11 would only say that
// a verb is missing.
void check_verb(const VerbProgram& program, std::span<const std::string> arguments) {
  if (!arguments.empty() && arguments.front().starts_with('-')) return;
  std::vector<std::string_view> known;
  for (const VerbRun& run : program.runs) known.push_back(run.word);
  const std::string all =
      fmt::format("there are {}; `{} --help`", fmt::join(known, ", "), program.name);
  if (arguments.empty()) throw usage_error(fmt::format("{}: which verb?", program.name), all);
  const std::string& word = arguments.front();
  if (std::ranges::find(known, word) != known.end()) return;
  throw usage_error(fmt::format("{}: no verb \"{}\"", program.name, word),
                    nearest_hint(word, known, all));
}

}  // namespace

int run_program(int argc, char** argv, const ParseCommandLine& parse) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return static_cast<int>(run(arguments, parse));
}

std::variant<Command, Text> parse_verb_program(const VerbProgram& program, Arguments arguments) {
  if (arguments.size() == 3 && arguments[0] == "__complete")
    return Text{lines_of(program.candidates(
        arguments[1], base::parse_number<std::size_t>(arguments[2]).value_or(0)))};
  // What stands behind "--" are arguments, whatever they look like. CLI11 would give them to the
  // program and not to the verb.
  const auto mark = std::ranges::find(arguments, "--");
  const std::span before(arguments.begin(), mark);
  const std::span behind(mark == arguments.end() ? mark : mark + 1, arguments.end());
  check_verb(program, before);
  Options options;
  CLI::App app(std::string(program.about), std::string(program.name));
  app.require_subcommand(1);
  app.set_version_flag("--version", fmt::format("{} {}", program.name, own_version()));
  std::vector<std::pair<const Verb*, CLI::App*>> own;
  for (const Verb& verb : program_verbs())
    if (verb.program == program.name) own.emplace_back(&verb, &add_verb(app, verb, options));
  try {
    std::vector<std::string> reversed(before.rbegin(), before.rend());
    app.parse(reversed);  // the last one first
  } catch (const CLI::CallForHelp&) {
    return Text{app.help()};
  } catch (const CLI::CallForVersion& version) {
    return Text{version.what() + std::string("\n")};
  } catch (const CLI::ParseError& error) {
    throw usage_error(error.what(), fmt::format("{} --help", program.name));
  }
  for (const auto& [verb, parsed] : own) {
    if (!parsed->parsed()) continue;
    if (takes_a_command(*verb)) options.arguments = parsed->remaining();
    options.arguments.insert(options.arguments.end(), behind.begin(), behind.end());
    check_arguments(fmt::format("{} {}", program.name, verb->word()), *verb, options.arguments);
    const auto run = std::ranges::find(program.runs, verb->word(), &VerbRun::word);
    return Command{verb, run->run, std::move(options)};
  }
  return Text{app.help()};
}

void check_arguments(const std::string& command, const Verb& verb,
                     const std::vector<std::string>& arguments) {
  const std::string usage = fmt::format("{} {}", command, verb.arguments);
  if (arguments.size() < verb.arguments_min)
    throw usage_error(fmt::format("{}: {} is missing", command, verb.arguments), usage);
  if (arguments.size() > verb.arguments_max)
    throw usage_error(
        fmt::format("{}: \"{}\" is one word too many", command, arguments[verb.arguments_max]),
        usage);
}

std::string_view own_version() { return TIMS_VERSION; }

bool is_in(std::string_view word, std::string_view list) {
  return fmt::format(" {} ", list).find(fmt::format(" {} ", word)) != std::string::npos;
}

}  // namespace timsctl

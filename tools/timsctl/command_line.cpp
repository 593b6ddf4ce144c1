#include "tools/timsctl/command_line.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "base/text.h"
#include "tools/cli/failure.h"
#include "tools/cli/options.h"
#include "tools/cli/service.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

// "--count=5", as split_words left it.
void set_option(const Verb& verb, std::string_view word, Options& options) {
  const std::string_view name = word.substr(2, word.find('=') - 2);
  const std::size_t equals = word.find('=');
  const std::string_view value =
      equals == std::string_view::npos ? std::string_view() : word.substr(equals + 1);
  if (!is_in(name, verb.options) && !is_in(name, kGeneralOptions))
    throw usage_error(fmt::format("timsctl {} has no option --{}", verb.name(), name),
                      fmt::format("timsctl {} --help", verb.name()));
  try {
    find_option(name)->set(options, value);
  } catch (const Failure& failure) {
    throw usage_error(fmt::format("--{}: {}", name, failure.message));
  }
}

void check_number_of_arguments(const Verb& verb, const std::vector<std::string>& arguments) {
  const std::string usage = fmt::format("timsctl {} {}", verb.name(), verb.arguments);
  if (arguments.size() < verb.arguments_min)
    throw usage_error(fmt::format("timsctl {}: {} is missing", verb.name(), verb.arguments), usage);
  if (arguments.size() > verb.arguments_max)
    throw usage_error(fmt::format("timsctl {}: \"{}\" is one word too many", verb.name(),
                                  arguments[verb.arguments_max]),
                      usage);
}

void check_form(const Verb& verb, Format format) {
  if (is_in(form_name(format), verb.forms)) return;
  std::string known(verb.forms);
  for (std::size_t at = 0; (at = known.find(' ', at)) != std::string::npos; at += 2)
    known.replace(at, 1, ", ");
  throw usage_error(fmt::format("timsctl {} has no -o {}", verb.name(), form_name(format)),
                    "it has " + known);
}

Text help_for(const Words& words) {
  if (words.words.empty() || words.words.front() == "help") return {overview()};
  const Resolved found = resolve(words.words);
  const bool only_a_noun = words.words.size() == 1 && !is_single(found.noun);
  if (found.verb == nullptr || only_a_noun) return {noun_help(found.noun)};
  return {verb_help(*found.verb)};
}

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

Exit become_own(Context& context) {
  become_verb(context.verb, context.options, context.options.arguments);
}

bool is_digit(char c) { return (c >= '0' && c <= '9') || c == '.'; }
// "-6"
bool is_number(std::string_view text) {
  return text.size() > 1 && std::ranges::all_of(text.substr(1), is_digit);
}

[[noreturn]] void refuse_unknown(std::string_view name) {
  std::vector<std::string_view> known;
  for (const OptionRow& row : option_table()) known.push_back(row.name);
  const auto near = base::nearest(name, known);
  throw usage_error("no option --" + std::string(name),
                    near ? "did you mean --" + std::string(*near) + "?" : "`timsctl --help`");
}

class Splitter {
 public:
  explicit Splitter(std::span<const std::string> arguments) : rest_(arguments) {}

  Words split() {
    while (!rest_.empty()) {
      const std::string_view token = take();
      if (token == "--") return with_the_rest();
      if (token.starts_with("--")) {
        take_long(token.substr(2));
      } else if (token.starts_with('-') && token.size() > 1 && !is_number(token)) {
        take_letters(token.substr(1));
      } else {
        out_.words.emplace_back(token);
        if (a_command_follows()) return with_the_rest();
      }
    }
    return std::move(out_);
  }

 private:
  Words with_the_rest() {
    out_.words.insert(out_.words.end(), rest_.begin(), rest_.end());
    return std::move(out_);
  }

  // "sim exec HOST COMMAND...": the options of another program are not ours.
  [[nodiscard]] bool a_command_follows() const {
    if (out_.words.size() != 3) return false;
    try {
      const Resolved found = resolve(out_.words);
      return found.verb != nullptr && found.words == 2 &&
             found.verb->arguments.ends_with("COMMAND...");
    } catch (const Failure&) {
      return false;  // said later, when all words are known
    }
  }

  std::string_view take() {
    const std::string_view token = rest_.front();
    rest_ = rest_.subspan(1);
    return token;
  }

  void take_long(std::string_view token) {
    const std::size_t equals = token.find('=');
    const std::string_view name = token.substr(0, equals);
    if (name == "help" || name == "version") {
      out_.options.push_back("--" + std::string(name));
      return;
    }
    const OptionRow* row = find_option(name);
    if (row == nullptr) refuse_unknown(name);
    if (equals == std::string_view::npos) return add(*row, {}, false);
    if (row->value.empty()) throw usage_error("--" + std::string(name) + " takes no value");
    add(*row, token.substr(equals + 1), true);
  }

  // "-jw", "-n5", "-n 5", "-jn5", "-w0.5"
  void take_letters(std::string_view letters) {
    for (; !letters.empty(); letters.remove_prefix(1)) {
      if (letters.front() == 'h') {
        out_.options.emplace_back("--help");
        continue;
      }
      const OptionRow* row = find_option(letters.front());
      if (row == nullptr)
        throw usage_error("no option -" + std::string(1, letters.front()), "`timsctl --help`");
      const bool attached = letters.size() > 1 && (row->takes_value() || is_digit(letters[1]));
      if (!row->value.empty() && attached) return add(*row, letters.substr(1), true);
      add(*row, {}, false);
    }
  }

  void add(const OptionRow& row, std::string_view value, bool given) {
    std::string option = "--" + std::string(row.name);
    if (!row.value.empty()) {
      if (!given && row.takes_value()) {
        if (rest_.empty()) throw usage_error(option + " needs a value: " + std::string(row.value));
        value = take();
      } else if (!given) {
        value = row.value.substr(1, row.value.size() - 2);  // "[2]": the default
      }
      option.append("=").append(value);
    }
    out_.options.push_back(std::move(option));
  }

  std::span<const std::string> rest_;
  Words out_;
};

constexpr std::size_t kWidth = 98;

// Up to its first full stop.
std::string_view first_sentence(std::string_view text) { return text.substr(0, text.find(". ")); }

std::string call_of(const Verb& verb) {
  return fmt::format("{}{}{}", verb.name(), verb.arguments.empty() ? "" : " ", verb.arguments);
}

std::string verb_line(const Verb& verb) {
  return fmt::format("  {:<29} {}\n", call_of(verb), first_sentence(verb.help));
}

std::string option_line(const OptionRow& row) {
  const std::string letter = row.letter != 0 ? fmt::format("-{}, ", row.letter) : "    ";
  const bool optional = row.value.starts_with('[');
  const std::string value = row.value.empty() ? ""
                            : optional        ? fmt::format("[={}", row.value.substr(1))
                                              : fmt::format(" {}", row.value);
  return fmt::format("  {:<29} {}\n", fmt::format("{}--{}{}", letter, row.name, value), row.help);
}

std::string option_lines(std::string_view names) {
  const std::string padded = fmt::format(" {} ", names);
  std::string text;
  for (const OptionRow& row : option_table())
    if (padded.find(fmt::format(" {} ", row.name)) != std::string::npos) text += option_line(row);
  return text;
}

// Broken at blanks.
std::string wrapped(std::string_view text) {
  std::string out;
  while (text.size() > kWidth) {
    const std::size_t blank = text.rfind(' ', kWidth);
    out.append(text.substr(0, blank)).append("\n");
    text.remove_prefix(blank + 1);
  }
  return out.append(text).append("\n");
}

constexpr std::string_view kExitCodes =
    "Exit status: 0 done, 1 no or failed, 2 wrong command line, 3 no router, 4 no such thing,\n"
    "5 denied, 6 no answer in time or only a part, 7 other protocol version, 130 interrupted.\n";

}  // namespace

void become_verb(const Verb& verb, const Options& options, std::span<const std::string> arguments) {
  tims::os::Command command{std::string(verb.program), verb.word()};
  command.insert(command.end(), options.given.begin(), options.given.end());
  command.emplace_back("--");
  command.insert(command.end(), arguments.begin(), arguments.end());
  become({.command = std::move(command)});
}

std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments) {
  if (!arguments.empty() && arguments[0] == "__complete") {
    Options options;
    options.arguments.assign(arguments.begin() + 1, arguments.end());
    const Verb* verb = resolve(arguments.first(1)).verb;
    return Command{verb, verb->run, std::move(options)};
  }
  Words words = split_words(arguments);
  if (contains(words.options, "--version")) return Text{version_text()};
  const bool help_word = !words.words.empty() && words.words.front() == "help";
  if (help_word || contains(words.options, "--help")) return help_for(words);

  if (words.words.empty()) words.words.emplace_back("status");
  const Resolved found = resolve(words.words);
  if (found.verb == nullptr)
    throw usage_error(fmt::format("timsctl {}: which verb?", found.noun),
                      fmt::format("timsctl {} --help", found.noun));
  Command command{found.verb, found.verb->run == nullptr ? become_own : found.verb->run, {}};
  for (const std::string& option : words.options) set_option(*found.verb, option, command.options);
  command.options.given = words.options;
  command.options.arguments.assign(words.words.begin() + static_cast<std::ptrdiff_t>(found.words),
                                   words.words.end());
  check_number_of_arguments(*found.verb, command.options.arguments);
  check_form(*found.verb, command.options.format);
  return command;
}

Words split_words(std::span<const std::string> arguments) { return Splitter(arguments).split(); }

std::string version_text() { return fmt::format("timsctl {}\n", own_version()); }

bool is_single(std::string_view noun) {
  return std::ranges::any_of(
      verbs(), [&](const Verb& verb) { return verb.noun == noun && verb.verb.empty(); });
}

std::string overview() {
  std::string text =
      "timsctl NOUN [VERB] [ARGUMENTS] [OPTIONS]: asks a router and its components.\n"
      "Unique beginnings are enough (`timsctl mb li`); without a word it is `timsctl status`.\n\n";
  for (const Verb& verb : verbs())
    if (!verb.example.empty()) text += verb_line(verb);
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  text += "  -h, --help                    of a noun or verb: its options and an example\n";
  text +=
      "\nADDR is Ladar(3/0), Ladar/3/0 (needs no quotes), Ladar/3/0:2 or 0x03140000. A GLOB has *\n"
      "in any place: 'Ladar(*/0)', Ladar.\n"
      "Environment: TIMS_HOST as -H, TIMS_ROUTER the router of programs here, NO_COLOR.\n";
  return text.append(kExitCodes);
}

std::string noun_help(std::string_view noun) {
  std::string text = fmt::format("timsctl {} VERB\n", noun);
  for (const Verb& verb : verbs())
    if (verb.noun == noun) text += verb_line(verb);
  return text + fmt::format("More: timsctl {} VERB --help\n", noun);
}

std::string verb_help(const Verb& verb) {
  std::string text = fmt::format("timsctl {}\n\n{}", call_of(verb), wrapped(verb.help));
  const std::string own = option_lines(verb.options);
  if (!own.empty()) text += "\nOptions:\n" + own;
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  return text + fmt::format("\nExample:\n  {}\n", verb.example);
}

}  // namespace timsctl

// timsctl completion: a script for the shell that asks `timsctl __complete WORDS...` for what may
// come next, living addresses included.
#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/option_table.h"
#include "tools/timsctl/values.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

constexpr std::string_view kBash = R"(_timsctl() {
  local IFS=$'\n' word="${COMP_WORDS[COMP_CWORD]}"
  # bash cuts words at ":"; take the line up to the cursor apart at blanks instead.
  local words; IFS=' ' read -r -a words <<< "${COMP_LINE:0:COMP_POINT}"
  [[ "${COMP_LINE:0:COMP_POINT}" == *' ' ]] && words+=("")
  local last="${words[-1]}"
  COMPREPLY=($(timsctl __complete "${words[@]:1}" 2>/dev/null))
  local cut="${last%"$word"}"
  COMPREPLY=("${COMPREPLY[@]#"$cut"}")
}
complete -F _timsctl timsctl
)";

constexpr std::string_view kZsh = R"(#compdef timsctl
_timsctl() {
  local -a candidates
  candidates=("${(@f)$(timsctl __complete "${(@)words[2,CURRENT]}" 2>/dev/null)}")
  compadd -- $candidates
}
compdef _timsctl timsctl
)";

constexpr std::string_view kFish = R"(function __timsctl_complete
  set -l words (commandline -opc) (commandline -ct)
  timsctl __complete $words[2..-1] 2>/dev/null
end
complete -c timsctl -f -a '(__timsctl_complete)'
)";

void add_options(const Verb& verb, std::vector<std::string>& out) {
  for (const OptionRow& row : option_table()) {
    const std::string padded = fmt::format(" {} {} ", verb.options, kGeneralOptions);
    if (padded.find(fmt::format(" {} ", row.name)) != std::string::npos)
      out.push_back(fmt::format("--{}", row.name));
  }
}

std::vector<std::string> living_addresses(const Context& context) {
  std::vector<std::string> out;
  const auto connection = context.connect();
  AdminClient admin(*connection, context.signals, std::chrono::milliseconds(500));
  const json::object answer = admin.ask({{"ask", "routes"}});
  for (const json::value& item : items_of(answer))
    if (const auto address = parse_address(text_at(item.as_object(), "address.raw"));
        address && address->fields(admin.widths()).class_id != tims::class_id::kTool)
      out.push_back(shell_name(*address, admin.widths()));
  return out;
}

// What may stand in the place of the last word, when the verb is known.
std::vector<std::string> arguments_of(const Verb& verb, const Context& context) {
  std::vector<std::string> out;
  const std::string_view wanted = verb.arguments;
  if (wanted.find('|') != std::string_view::npos) {
    std::string_view rest = wanted;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find('|'), rest.size());
      if (rest.substr(0, end) != "ADDR") out.emplace_back(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  if (wanted.find("ADDR") == std::string_view::npos &&
      wanted.find("GLOB") == std::string_view::npos)
    return out;
  try {
    const auto addresses = living_addresses(context);
    out.insert(out.end(), addresses.begin(), addresses.end());
  } catch (const Failure&) {
    // No router, no addresses.
  }
  return out;
}

std::vector<std::string> candidates(std::span<const std::string> words, const Context& context) {
  std::vector<std::string> out;
  std::vector<std::string> plain;
  for (const std::string& word : words.first(words.size() - 1))
    if (!word.starts_with('-')) plain.push_back(word);
  if (plain.empty() && !words.back().starts_with('-')) {
    for (const Verb& verb : verbs())
      if (!verb.example.empty()) out.emplace_back(verb.noun);
    return out;
  }
  const Resolved found = resolve(plain);
  const bool verb_comes =
      plain.size() == 1 && found.words == 1 && (found.verb == nullptr || !found.verb->verb.empty());
  if (words.back().starts_with('-')) {
    if (found.verb != nullptr) add_options(*found.verb, out);
    return out;
  }
  for (const Verb& verb : verbs())
    if (verb_comes && verb.noun == found.noun) out.emplace_back(verb.verb);
  if (found.verb == nullptr || verb_comes) return out;
  if (found.noun == "sim") return sim_candidates(found.verb->verb, plain.size() - found.words);
  return arguments_of(*found.verb, context);
}

}  // namespace

Exit completion(Context& context) {
  const std::string& shell = context.options.arguments.front();
  const std::string_view script = shell == "bash"   ? kBash
                                  : shell == "zsh"  ? kZsh
                                  : shell == "fish" ? kFish
                                                    : "";
  if (script.empty())
    throw usage_error(fmt::format("completion: no script for \"{}\"", shell),
                      "there are bash, zsh and fish");
  if (context.out.json())
    context.out.write(
        json::object{{"schema", "tims/completion/1"}, {"shell", shell}, {"script", script}});
  else
    context.out.write(script);
  return Exit::kDone;
}

Exit complete(Context& context) {
  std::vector<std::string> words = context.options.arguments;
  if (words.empty()) words.emplace_back();
  std::vector<std::string> all;
  try {
    all = candidates(words, context);
  } catch (const Failure&) {
    return Exit::kDone;  // words that name nothing have no completion
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (const std::string& candidate : all)
    if (candidate.starts_with(words.back())) context.out.write(candidate + "\n");
  return Exit::kDone;
}

}  // namespace timsctl

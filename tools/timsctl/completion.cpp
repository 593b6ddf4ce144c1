// timsctl completion: a shell script that calls `timsctl __complete WORDS...` for the possible
// continuations, including registered addresses.
#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "base/text.h"
#include "components/devices/io/host_devices.h"
#include "rack/codec/message_text.h"
#include "rack/proxies/world.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/options.h"
#include "tools/cli/service.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"
#include "tools/timsctl/world.h"

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
  [[ "${COMPREPLY[0]}" == *= ]] && compopt -o nospace
}
complete -o default -F _timsctl timsctl
)";

constexpr std::string_view kZsh = R"zsh(#compdef timsctl
_timsctl() {
  local -a candidates
  candidates=(${(f)"$(timsctl __complete "${(@)words[2,CURRENT]}" 2>/dev/null)"})
  if (( ! $#candidates )); then _files; return; fi
  # The value follows "=" directly.
  compadd -S '' -- ${(M)candidates:#*=}
  compadd -- ${candidates:#*=}
}
compdef _timsctl timsctl
)zsh";

constexpr std::string_view kFish = R"fish(function __timsctl_complete
  set -l words (commandline -opc) (commandline -ct)
  set -l found (timsctl __complete $words[2..-1] 2>/dev/null)
  if test (count $found) -gt 0
    printf '%s\n' $found
  else
    __fish_complete_path (commandline -ct)
  end
end
complete -c timsctl -f -a '(__timsctl_complete)'
)fish";

using Candidates = std::vector<std::string>;

void add_options(const Verb& verb, Candidates& out) {
  for (const OptionRow& row : option_table())
    if (has_option(verb, row)) out.push_back(fmt::format("--{}", row.name));
}

Candidates split(std::string_view text, char at) {
  Candidates out;
  for (const std::string_view part : parts_of(text, at))
    if (!part.empty()) out.emplace_back(part);
  return out;
}

// --- candidates from the router, a component or this host. Empty without an answer.

Candidates living_addresses(const Context& context, std::optional<std::uint32_t> class_id = {}) {
  Candidates out;
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer = admin.ask({{"ask", "routes"}});
  for (const json::object& item : objects(items_of(answer))) {
    const auto address = parse_address(text_at(item, "address.raw"));
    if (!address) continue;
    const std::uint32_t its_class = address->fields(admin.widths()).class_id;
    if (class_id ? its_class == *class_id : its_class != tims::class_id::kTool)
      out.push_back(shell_name(*address, admin.widths()));
  }
  return out;
}

Candidates item_names(const json::object& answer) {
  Candidates out;
  for (const json::object& item : objects(items_of(answer))) out.push_back(text_at(item, "name"));
  return out;
}

Candidates peers(const Context& context) {
  const auto connection = context.connect();
  return item_names(context.admin(*connection).ask({{"ask", "links"}}));
}

Candidates routers(const Context& context) {
  const auto connection = context.connect();
  return item_names(walk_fleet(context.admin(*connection)));
}

Candidates parameters(Context& context, const std::string& component) {
  ComponentClient client(context);
  Candidates out;
  const auto list = client.parameters(client.address(component));
  for (const rack::Parameter& parameter : list.parameters) out.emplace_back(parameter.name.view());
  return out;
}

// The candidates of a verb of another program come from that program.
Candidates of_program(std::string_view program, const std::string& verb, std::size_t place) {
  const Ran ran =
      run({.command = {std::string(program), "__complete", verb, std::to_string(place)}});
  return ran.status.success() ? split(ran.output, '\n') : Candidates();
}

Candidates devices() {
  Candidates out;
  for (const auto& device : rack::device::host_devices())
    if (const std::string address = device_address(device); !address.empty())
      out.push_back(address);
  return out;
}

Candidates classes() {
  Candidates out;
  for (const auto table : rack::message_tables())
    for (const rack::MessageInfo& message : table)
      if (message.class_id != rack::kEveryClass)
        out.emplace_back(tims::class_name(message.class_id));
  return out;
}

Candidates messages(std::uint32_t class_id, bool commands) {
  Candidates out;
  for (const auto table : rack::message_tables())
    for (const rack::MessageInfo& message : table)
      if ((message.class_id == class_id || message.class_id == rack::kEveryClass) &&
          (!commands || message.type > 0))
        out.push_back(base::lower(message.name));
  return out;
}

Candidates fields(std::uint32_t class_id, const std::string& name) {
  const rack::MessageInfo* message = rack::find_message(class_id, name);
  Candidates out;
  if (message != nullptr && message->body != nullptr)
    for (const rack::Column& column : rack::columns_of(*message->body))
      if (column.type != "count") out.push_back(column.name + "=");
  return out;
}

// --- candidates by position

// The name of the argument at that position: "ADDR" in "get|set ADDR [NAME] [VALUE]".
std::string place_name(std::string_view arguments, std::size_t place) {
  Candidates places = split(arguments, ' ');
  if (places.empty()) return {};
  const bool repeats = places.back().find("...") != std::string::npos;
  if (place >= places.size() && !repeats) return {};
  // "[FIELD=VALUE...] [-]": repeated arguments may precede others.
  const auto repeated = std::ranges::find_if(
      places, [](const std::string& p) { return p.find("...") != std::string::npos; });
  const auto at = std::min(place, static_cast<std::size_t>(repeated - places.begin()));
  std::string name = places[std::min(at, places.size() - 1)];
  std::erase_if(name, [](char c) { return c == '[' || c == ']' || c == '.'; });
  return name;
}

// The candidates for an argument; `before`: the preceding arguments.
Candidates for_place(const Verb& verb, std::string_view name, const Candidates& before,
                     Context& context) {
  const auto class_before = [&] { return need_class(before.front()); };
  if (name == "ADDR" || name == "GLOB" || name == "SRC" || name == "DST")
    return living_addresses(context);
  if (name == "CHASSIS") return living_addresses(context, tims::class_id::kChassis);
  if (name == "PILOT") return living_addresses(context, tims::class_id::kPilot);
  if (name == "ROUTER" || (name == "NAME" && verb.noun == "link")) return peers(context);
  if (name == "NAME" && verb.verb == "param") return parameters(context, before.back());
  if (name == "NAME" && verb.verb == "show") return messages(class_before(), false);
  if (name == "ROBOT") return routers(context);
  if (name == "DEVICE") return devices();
  if (name == "CLASS") return classes();
  if (name == "TYPE") return messages(class_before(), true);
  if (name == "FIELD=VALUE" && before.size() > 1) return fields(class_before(), before[1]);
  if (name == "ROBOT" || name == "SENSOR") {
    Candidates out;
    for (const auto& [robot, sensor] : world_devices(context)) {
      if (name == "ROBOT") out.push_back(robot);
      if (name == "SENSOR" && robot == before.front()) out.push_back(sensor);
    }
    return out;
  }
  if (name == "CODE") {
    Candidates out;
    for (const CatalogueEntry& entry : catalogue()) out.emplace_back(entry.code);
    return out;
  }
  const bool literal = std::ranges::all_of(name, [](char c) { return c >= 'a' && c <= 'z'; });
  return literal ? Candidates{std::string(name)} : Candidates{};
}

// The candidates for the value of an option.
Candidates for_option(std::string_view option, const Verb* verb, Context& context) {
  if (option == "output") return split(verb == nullptr ? kRows : verb->forms, ' ');
  if (option == "router" || option == "robot") return routers(context);
  if (option == "link") return peers(context);
  if (option == "from" || option == "component" || option == "listen")
    return living_addresses(context);
  if (option == "world") return living_addresses(context, rack::kWorld);
  if (option == "type") return messages(rack::kEveryClass, false);
  if (option == "level") return {"print", "error", "warning", "info", "detail"};
  if (option == "by") return {"reason", "port", "class"};
  if (option == "format") return {"text", "nagios"};
  if (option == "fleet") return of_program("timsctl-sim", "down", 0);
  return {};  // the shell completes file names
}

// Stands for the word that is being completed. No word of a shell begins like this.
constexpr std::string_view kHere = "\1";

// `last`: the beginning of the word that is kHere in the line.
Candidates candidates(const Line& line, const std::string& last, Context& context) {
  Candidates out;
  Candidates plain = line.arguments;
  std::erase(plain, kHere);
  const Resolved found = resolve(plain);
  if (plain.size() == line.arguments.size() && !line.options.empty())
    return for_option(line.options.back().option->name, found.verb, context);
  if (const std::size_t equals = last.find('=');
      last.starts_with("--") && equals != std::string_view::npos) {
    for (const std::string& value : for_option(last.substr(2, equals - 2), found.verb, context))
      out.push_back(last.substr(0, equals + 1) + value);
    return out;
  }
  if (last.starts_with('-')) {
    if (found.verb != nullptr) add_options(*found.verb, out);
    return out;
  }
  if (plain.empty()) {
    for (const Verb& verb : verbs())
      if (!verb.example.empty()) out.emplace_back(verb.noun);
    return out;
  }
  const bool verb_comes =
      plain.size() == 1 && found.used == 1 && (found.verb == nullptr || !found.verb->verb.empty());
  for (const Verb& verb : verbs())
    if (verb_comes && verb.noun == found.noun) out.emplace_back(verb.verb);
  if (found.verb == nullptr || verb_comes) return out;
  const std::size_t place = plain.size() - found.used;
  if (!found.verb->program.empty())
    return of_program(found.verb->program, found.verb->short_name(), place);
  const Candidates arguments(plain.begin() + static_cast<std::ptrdiff_t>(found.used), plain.end());
  for (const std::string& name : split(place_name(found.verb->arguments, place), '|'))
    for (std::string& candidate : for_place(*found.verb, name, arguments, context))
      out.push_back(std::move(candidate));
  return out;
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
                      "supported: bash, zsh and fish");
  context.out.write({{"schema", "tims/completion/1"}, {"shell", shell}, {"script", script}},
                    [&] { return std::string(script); });
  return Exit::kDone;
}

Exit complete(Context& context) {
  std::vector<std::string> arguments = context.options.arguments;
  if (arguments.empty()) arguments.emplace_back();
  const std::string last = std::exchange(arguments.back(), std::string(kHere));
  Options options = context.options;
  options.timeout = std::chrono::milliseconds(500);  // the user waits for the completion
  std::vector<std::string> all;
  try {
    const Line line = split_line(timsctl_program(), arguments);
    const auto host = std::ranges::find_if(
        line.options, [](const Line::Given& given) { return given.option->name == "host"; });
    Context there(context.verb, options, context.out, context.signals,
                  host == line.options.end() ? context.host : parse_host(host->value));
    all = candidates(line, last, there);
  } catch (const Failure&) {
    return Exit::kDone;  // an unknown verb or a missing router means no candidates
  }
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (const std::string& candidate : all)
    if (candidate.starts_with(last)) context.out.write(candidate + "\n");
  return Exit::kDone;
}

}  // namespace timsctl

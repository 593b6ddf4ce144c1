#include "router/io/arguments.h"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/core.h>

namespace tims::io {
namespace {

// "--name VALUE" and "--name=VALUE"; `rest` is shortened by what was used. Nothing when the first
// word is another one.
std::optional<std::string_view> option_value(std::string_view name,
                                             std::span<const char* const>& rest) {
  const std::string_view word = rest.front();
  if (!word.starts_with(name)) return std::nullopt;
  const std::string_view behind = word.substr(name.size());
  if (behind.starts_with('=')) {
    rest = rest.subspan(1);
    return behind.substr(1);
  }
  if (!behind.empty() || rest.size() < 2) return std::nullopt;
  const std::string_view value = rest[1];
  rest = rest.subspan(2);
  return value;
}

std::optional<Arguments::Action> action_of(std::string_view word) {
  using Action = Arguments::Action;
  if (word == "check") return Action::kCheck;
  if (word == "--print-config") return Action::kPrintConfig;
  if (word == "--version") return Action::kVersion;
  if (word == "--help" || word == "-h") return Action::kHelp;
  return std::nullopt;
}

// Of getopt: "-p VALUE" and "-pVALUE".
std::optional<std::string_view> short_value(std::string_view name,
                                            std::span<const char* const>& rest) {
  const std::string_view word = rest.front();
  if (!word.starts_with(name) || word.size() == name.size()) return option_value(name, rest);
  rest = rest.subspan(1);
  return word.substr(name.size());
}

// The options of the original's tims_router_tcp, which start scripts of RACK 0.6.1 call.
struct OriginalOptions {
  std::optional<std::string_view> address{};
  std::optional<std::string_view> port{};

  bool take(std::span<const char* const>& words, Arguments& arguments) {
    if (const auto ip = short_value("-i", words)) {
      address = ip;
    } else if (const auto number = short_value("-p", words)) {
      port = number;
    } else if (const auto kib = short_value("-m", words)) {
      arguments.settings.emplace_back(fmt::format("message.max={}KiB", *kib));
    } else if (const auto level = short_value("-l", words)) {
      if (*level != "0") arguments.settings.emplace_back("log.level=debug");
    } else if (const auto priority = short_value("-P", words)) {
      arguments.settings.emplace_back(fmt::format("router.priority={}", *priority));
    } else {
      return false;
    }
    return true;
  }
};

bool wants_value(std::string_view word) {
  constexpr std::array<std::string_view, 7> kOptions = {"--config", "--set", "-i", "-p",
                                                        "-m",       "-l",    "-P"};
  return std::ranges::find(kOptions, word) != kOptions.end();
}

}  // namespace

Result<Arguments> parse_arguments(std::span<const char* const> words) {
  Arguments arguments;
  OriginalOptions original;
  while (!words.empty()) {
    const std::string_view word = words.front();
    if (const auto action = action_of(word)) {
      arguments.action = *action;
      words = words.subspan(1);
    } else if (const auto path = option_value("--config", words)) {
      arguments.config_path = *path;
    } else if (const auto setting = option_value("--set", words)) {
      arguments.settings.emplace_back(*setting);
    } else if (original.take(words, arguments)) {
    } else if (wants_value(word)) {
      return Error(Errc::kInvalidArgument, fmt::format("{} wants something behind it", word));
    } else {
      return Error(Errc::kInvalidArgument, fmt::format("\"{}\" is not known here", word));
    }
  }
  if (original.address || original.port)
    arguments.settings.emplace_back(fmt::format("tcp.listen={}:{}",
                                                original.address.value_or("127.0.0.1"),
                                                original.port.value_or("2000")));
  return arguments;
}

std::string_view usage() {
  return R"(usage: tims-router [--config FILE] [--set KEY=VALUE]... [ACTION]

Routes messages between the components of this host and everything that connects over TCP or
WebSocket.

  --config FILE      read the configuration from FILE, then from *.toml in the folder FILE.d
                     (router.toml, router.d/*.toml)
  --set KEY=VALUE    one value over all files; as often as needed

As the original's tims_router_tcp, which this program is called too:
  -i ADDRESS, -p PORT  where to listen (127.0.0.1 and 2000): --set tcp.listen=ADDRESS:PORT
  -m KIB             --set message.max=KIBKiB
  -l LEVEL           0: as configured; 1, 2: --set log.level=debug
  -P PRIORITY        --set router.priority=PRIORITY

Actions other than to run:
  check              say whether the configuration is good, and end
  --print-config     print every value and where it comes from, and end
  --version, --help

Ends with 0 when asked to (SIGTERM, SIGINT), 1 when it cannot start or the check fails, 2 when
called wrongly. SIGHUP reads the configuration again.
)";
}

}  // namespace tims::io

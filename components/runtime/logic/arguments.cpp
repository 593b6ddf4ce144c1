#include "components/runtime/logic/arguments.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace rack {
namespace {

constexpr std::string_view kHelp = "help";
constexpr std::string_view kVersion = "version";
// Not abbreviated: --de may be a parameter of the component.
constexpr std::string_view kDescribe = "describe";
constexpr std::string_view kRouter = "router";

tims::Error wrong(std::string text) {
  return {tims::Errc::kInvalidArgument, std::move(text) + " (--help lists the options)"};
}

std::vector<std::string_view> known_names(const Parameters& parameters) {
  std::vector<std::string_view> names{kHelp, kVersion, kRouter};
  for (const auto& entry : parameters.entries()) names.push_back(entry.info->name);
  return names;
}

// The option with this name, or the only one with this prefix.
tims::Result<std::string_view> option(std::string_view text, const Parameters& parameters) {
  std::vector<std::string_view> found;
  for (const std::string_view whole : {kHeldOffBy, kDescribe})
    if (text == whole) return whole;
  for (const std::string_view name : known_names(parameters)) {
    if (name == text) return name;
    if (!text.empty() && name.starts_with(text)) found.push_back(name);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) return wrong("unknown option --" + std::string(text));
  std::string can_be = "--" + std::string(text) + " can be";
  for (const std::string_view name : found)
    can_be += (name == found.front() ? " --" : " or --") + std::string(name);
  return wrong(std::move(can_be));
}

tims::Result<void> nothing_missing(const Parameters& parameters) {
  for (const auto& entry : parameters.entries()) {
    if (entry.info->required && !entry.given)
      return wrong("--" + std::string(entry.info->name) +
                   " is missing: " + std::string(entry.info->help));
  }
  return {};
}

}  // namespace

tims::Result<Arguments> parse_arguments(std::span<const char* const> arguments,
                                        Parameters& parameters) {
  Arguments result;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (!argument.starts_with('-'))
      return wrong(std::string(argument) + " is not an option: options begin with --");
    const std::string_view text = argument.substr(argument.starts_with("--") ? 2 : 1);
    const std::size_t equals = text.find('=');
    const auto name = option(text.substr(0, equals), parameters);
    if (!name) return name.error();
    if (*name == kHelp) {
      result.help = true;
      return result;
    }
    if (*name == kVersion) {
      result.version = true;
      return result;
    }
    if (*name == kDescribe) {
      result.describe = true;
      return result;
    }
    std::optional<std::string_view> value;
    if (equals != std::string_view::npos) value = text.substr(equals + 1);
    if (!value && i + 1 < arguments.size()) value = arguments[++i];
    if (!value) return wrong("--" + std::string(*name) + " needs a value");
    if (*name == kRouter) {
      result.router = *value;
    } else if (*name == kHeldOffBy) {
      result.held_off_by = tims::Address::parse(*value);
    } else if (const auto set = parameters.set(*name, *value); !set) {
      return wrong("--" + set.error().detail());
    }
  }
  if (const auto complete = nothing_missing(parameters); !complete) return complete.error();
  return result;
}

std::string usage(const Parameters& parameters, std::string_view purpose) {
  constexpr std::size_t kHelpColumn = 24;
  std::string text =
      parameters.program() + " [--OPTION VALUE]...\n\n" + std::string(purpose) + "\n\n";
  const auto line = [&](std::string_view name, std::string_view help) {
    std::string option(name);
    option.resize(std::max(kHelpColumn, option.size() + 1), ' ');
    text += "  --" + option + std::string(help) + "\n";
  };
  line(kRouter, "unix:PATH or HOST:PORT (default: $TIMS_ROUTER, else this host's socket)");
  for (const auto& entry : parameters.entries()) {
    std::string help(entry.info->help);
    if (!entry.info->choices.empty()) help.append(": ").append(entry.info->choices);
    line(entry.info->name,
         help + " (" + default_of(*entry.info) + "; " + allowed(*entry.info) + ")");
  }
  line(kHelp, "this");
  line(kDescribe, "print the parameters, inputs and outputs as JSON");
  line(kVersion, "print the version");
  return text;
}

}  // namespace rack

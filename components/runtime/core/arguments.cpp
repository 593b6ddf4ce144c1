#include "components/runtime/core/arguments.h"

#include <optional>
#include <vector>

#include <fmt/format.h>

namespace rack {
namespace {

constexpr std::string_view kHelp = "help";
constexpr std::string_view kRouter = "router";

tims::Error wrong(std::string text) {
  return {tims::Errc::kInvalidArgument, std::move(text) + " (--help lists the options)"};
}

std::vector<std::string_view> known_names(const Parameters& parameters) {
  std::vector<std::string_view> names{kHelp, kRouter};
  for (const auto& entry : parameters.entries()) names.push_back(entry.info->name);
  return names;
}

// The one option that begins like this, or is this.
tims::Result<std::string_view> option(std::string_view text, const Parameters& parameters) {
  std::vector<std::string_view> found;
  for (const std::string_view name : known_names(parameters)) {
    if (name == text) return name;
    if (!text.empty() && name.starts_with(text)) found.push_back(name);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) return wrong(fmt::format("unknown option --{}", text));
  return wrong(fmt::format("--{} can be --{}", text, fmt::join(found, " or --")));
}

std::string default_of(const ParameterInfo& info) {
  if (info.required) return "required";
  if (const auto* text = std::get_if<std::string>(&info.initial))
    return text->empty() ? "none" : *text;
  return std::visit([](const auto& value) { return fmt::format("{}", value); }, info.initial);
}

tims::Result<void> nothing_missing(const Parameters& parameters) {
  for (const auto& entry : parameters.entries()) {
    if (entry.info->required && !entry.given)
      return wrong(fmt::format("--{} is missing: {}", entry.info->name, entry.info->help));
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
      return wrong(fmt::format("{} is no option: they begin with --", argument));
    const std::string_view text = argument.substr(argument.starts_with("--") ? 2 : 1);
    const std::size_t equals = text.find('=');
    const auto name = option(text.substr(0, equals), parameters);
    if (!name) return name.error();
    if (*name == kHelp) {
      result.help = true;
      return result;
    }
    std::optional<std::string_view> value;
    if (equals != std::string_view::npos) value = text.substr(equals + 1);
    if (!value && i + 1 < arguments.size()) value = arguments[++i];
    if (!value) return wrong(fmt::format("--{} needs a value", *name));
    if (*name == kRouter) {
      result.router = *value;
    } else if (const auto set = parameters.set(*name, *value); !set) {
      return wrong("--" + set.error().detail());
    }
  }
  if (const auto complete = nothing_missing(parameters); !complete) return complete.error();
  return result;
}

std::string usage(const Parameters& parameters, std::string_view purpose) {
  std::string text = fmt::format("{} [--OPTION VALUE]...\n\n{}\n\n", parameters.program(), purpose);
  const auto line = [&](std::string_view name, std::string_view help) {
    text += fmt::format("  --{:<22} {}\n", name, help);
  };
  line(kRouter, "unix:PATH or HOST:PORT (default: $TIMS_ROUTER, else this host's socket)");
  for (const auto& entry : parameters.entries()) {
    line(entry.info->name, fmt::format("{} ({}; {})", entry.info->help, default_of(*entry.info),
                                       allowed(*entry.info)));
  }
  line(kHelp, "this");
  return text;
}

}  // namespace rack

// The command line, implemented with CLI11: the only file that includes it, because it compiles
// slowly. Error messages are this program's own.
#include "router/io/arguments.h"

#include <algorithm>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "base/text.h"

namespace tims::io {
namespace {

constexpr const char* kOriginals =
    "As the original's tims_router_tcp, which this program is called too";
constexpr const char* kActions = "Actions other than running";

// The usage line and description; CLI11 appends the options.
class Help final : public CLI::Formatter {
 public:
  Help() { column_width(21); }
  std::string make_description(const CLI::App*) const override { return {}; }
  std::string make_usage(const CLI::App* app, std::string name) const override {
    return fmt::format("usage: {} [--config FILE] [--set KEY=VALUE]... [check]\n\n{}\n", name,
                       app->get_description());
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    const std::string& type = option->get_type_name();
    return type.empty() ? "" : " " + type;
  }
};

// The parser and its results.
class CommandLine {
 public:
  CommandLine() {
    app_.formatter(std::make_shared<Help>());
    app_.set_help_flag();
    app_.allow_extras();
    app_.footer(
        "Exits with 0 on SIGTERM or SIGINT, 1 when it cannot start or the check fails, "
        "2 on\nwrong usage. SIGHUP reloads the configuration.");
    option("--config", "FILE",
           "read the configuration from FILE, then from *.toml in the folder FILE.d\n"
           "(router.toml, router.d/*.toml)",
           [this](const std::string& path) { arguments_.config_path = path; });
    option("--set", "KEY=VALUE", "override one value of all files; repeatable",
           [this](const std::string& setting) { arguments_.settings.push_back(setting); });
    add_originals();
    app_.add_subcommand("check", "check the configuration and exit")
        ->fallthrough()
        ->group(kActions)
        ->callback([this] { arguments_.action = Arguments::Action::kCheck; });
    action("--print-config", "print every value with its origin and exit",
           Arguments::Action::kPrintConfig);
    action("--version", "print the version and exit", Arguments::Action::kVersion);
    action("-h,--help", "print this help and exit", Arguments::Action::kHelp);
  }

  Result<Arguments> parse(std::span<const char* const> argv) {
    std::vector<std::string> reversed(argv.rbegin(), argv.rend());  // the order CLI11 expects
    try {
      app_.parse(reversed);
    } catch (const CLI::ArgumentMismatch& error) {
      const std::string what = error.what();  // "--set: 1 required ..."
      return wrong(fmt::format("{} needs a value", what.substr(0, what.find(':'))));
    } catch (const CLI::ParseError& error) {
      return wrong(error.what());
    }
    if (const auto unknown = app_.remaining(true); !unknown.empty())
      return wrong(fmt::format("\"{}\" is not known here{}", unknown.front(),
                               did_you_mean(unknown.front())));
    if (address_ || port_)
      arguments_.settings.push_back(
          fmt::format("tcp.listen={}:{}", address_.value_or("127.0.0.1"), port_.value_or("2000")));
    return std::move(arguments_);
  }

  [[nodiscard]] std::string help() const {
    std::string text = app_.help();
    for (auto at = text.find("\n\n\n"); at != std::string::npos; at = text.find("\n\n\n"))
      text.erase(at, 1);
    return text;
  }

 private:
  // Called immediately for each occurrence, because the order of options matters.
  template <typename Take>
  CLI::Option* option(const char* name, const char* value, const char* help, Take take) {
    return app_.add_option_function<std::string>(name, take, help)
        ->type_name(value)
        ->trigger_on_parse();
  }

  void action(const char* name, const char* help, Arguments::Action what) {
    app_.add_flag_callback(
            name, [this, what] { arguments_.action = what; }, help)
        ->trigger_on_parse();
  }

  // Options used by the start scripts of RACK 0.6.1.
  void add_originals() {
    const auto setting = [this](const char* format) {
      return [this, format](const std::string& value) {
        arguments_.settings.push_back(fmt::format(fmt::runtime(format), value));
      };
    };
    option("-i", "ADDRESS", "with PORT: --set tcp.listen=ADDRESS:PORT (127.0.0.1)",
           [this](const std::string& address) { address_ = address; })
        ->group(kOriginals);
    option("-p", "PORT", "listen on PORT (2000)", [this](const std::string& port) {
      port_ = port;
    })->group(kOriginals);
    option("-m", "KIB", "--set message.max=KIBKiB", setting("message.max={}KiB"))
        ->group(kOriginals);
    option("-l", "LEVEL", "0: as configured; 1, 2: --set log.level=debug",
           [this](const std::string& level) {
             if (level != "0") arguments_.settings.emplace_back("log.level=debug");
           })
        ->group(kOriginals);
    option("-P", "PRIORITY", "--set router.priority=PRIORITY", setting("router.priority={}"))
        ->group(kOriginals);
  }

  [[nodiscard]] std::string did_you_mean(const std::string& argument) const {
    std::vector<std::string> known{"check"};
    for (const CLI::Option* each : app_.get_options())
      for (const std::string& name : each->get_lnames()) known.push_back("--" + name);
    const auto near = base::nearest(argument.substr(0, argument.find('=')), known);
    return near ? fmt::format(" (did you mean {}?)", *near) : "";
  }

  static Error wrong(std::string what) { return {Errc::kInvalidArgument, std::move(what)}; }

  Arguments arguments_;
  std::optional<std::string> address_;
  std::optional<std::string> port_;
  CLI::App app_{
      "Routes messages between the components of this host and all programs that connect over TCP "
      "or\n"
      "WebSocket.",
      "tims-router"};
};

}  // namespace

Result<Arguments> parse_arguments(std::span<const char* const> argv) {
  return CommandLine().parse(argv);
}

std::string usage() { return CommandLine().help(); }

}  // namespace tims::io

#include "components/demo/demo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace tims::demo {

namespace {

struct Role {
  const char* name;
  const char* help;
  Address at;
  Address to;  // raw 0: the component does not contact others
  double rate_hz;
};

constexpr std::array kRoles = {
    Role{"ladar", "a laser range finder, Ladar(0/0)", kLadar, {}, 75},
    Role{"viewer", "subscribes to a ladar, prints one line per second", kViewer, kLadar, 0},
    Role{"server", "Test(0/0): answers requests with the bytes reversed", kServer, {}, 0},
    Role{"client", "sends requests to a server", kClient, kServer, 10},
};

Duration period_of(double rate_hz) {
  return rate_hz > 0 ? Duration(static_cast<std::int64_t>(1e9 / rate_hz)) : Duration{};
}

void add_address(CLI::App& app, const char* name, Address& to, const char* help) {
  const auto parse = [&to, name](const std::string& text) {
    const auto address = Address::parse(text);
    if (!address)
      throw CLI::ValidationError(name,
                                 text + " is not an address; write Ladar(3/0) or 'Test(1/2):1'");
    to = *address;
  };
  app.add_option_function<std::string>(name, parse, help)->type_name("ADDR");
}

void add_rate(CLI::App& app, Duration& period, double usual) {
  const auto parse = [&period](const double& rate) {
    if (std::isnan(rate) || rate < 0.1 || rate > 1000)
      throw CLI::ValidationError("--rate", "must be 0.1 to 1000 Hz");
    period = period_of(rate);
  };
  app.add_option_function<double>("--rate", parse, fmt::format("rate (default: {})", usual))
      ->type_name("HZ");
}

}  // namespace

std::variant<Arguments, Refusal> parse_arguments(std::vector<std::string> arguments) {
  CLI::App app("A small component for trying out a fleet, at the router of $TIMS_ROUTER.",
               "tims-demo");
  app.set_version_flag("--version", TIMS_VERSION);
  app.require_subcommand(1);
  std::array<Arguments, kRoles.size()> all;
  for (std::size_t i = 0; i < kRoles.size(); ++i) {
    const Role& role = kRoles[i];
    all[i] = {.role = role.name, .at = role.at, .to = role.to, .period = period_of(role.rate_hz)};
    CLI::App& command = *app.add_subcommand(role.name, role.help);
    add_address(command, "--at", all[i].at,
                "address of its mailbox; several components need different ones");
    if (role.to != Address()) add_address(command, "--to", all[i].to, "address of its peer");
    if (role.rate_hz > 0) add_rate(command, all[i].period, role.rate_hz);
  }
  if (!arguments.empty() && !arguments[0].starts_with('-') &&
      std::ranges::find(all, arguments[0], &Arguments::role) == all.end())
    return Refusal{2, "no component \"" + arguments[0] + "\""};
  std::ranges::reverse(arguments);  // CLI11 expects the reverse order
  try {
    app.parse(arguments);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = app.get_subcommands();
    return Refusal{0, chosen.empty() ? app.help() : chosen.front()->help()};
  } catch (const CLI::CallForVersion&) {
    return Refusal{0, app.version() + "\n"};
  } catch (const CLI::ParseError& error) {
    return Refusal{2, error.what()};
  }
  return *std::ranges::find(all, app.get_subcommands().front()->get_name(), &Arguments::role);
}

rack::LadarData scan_of_a_room(std::uint32_t number, rack::TimeStamp time) {
  constexpr int kPoints = 361;
  constexpr float kHalf = std::numbers::pi_v<float> / 2;
  rack::LadarData scan{.recordingTime = time,
                       .duration = 13,
                       .maxRange = 8191,
                       .startAngle = -kHalf,
                       .endAngle = kHalf};
  for (int i = 0; i < kPoints; ++i) {
    const float angle = -kHalf + static_cast<float>(i) * (2 * kHalf / (kPoints - 1));
    const float wall = 3000 + 500 * std::sin(static_cast<float>(number) / 75 + 4 * angle);
    scan.points.push_back(
        {.angle = angle, .distance = static_cast<rack::i32>(wall), .intensity = 100});
  }
  return scan;
}

}  // namespace tims::demo

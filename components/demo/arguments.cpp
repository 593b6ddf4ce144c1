#include "components/demo/arguments.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace tims::demo {

namespace {

struct Role {
  std::string_view name;
  Address at;  // raw 0: made from what it talks to
  Address to;  // raw 0: it talks to nobody by itself
  double rate_hz;
};

constexpr std::array kRoles = {Role{"ladar", kLadar, {}, 75}, Role{"viewer", kViewer, kLadar, 0},
                               Role{"server", kServer, {}, 0},
                               Role{"client", kClient, kServer, 10}};

using Parsed = std::variant<Arguments, std::string>;

std::string in_quotes(std::string_view text) { return "\"" + std::string(text) + "\""; }

Duration period_of(double rate_hz) {
  return rate_hz > 0 ? Duration(static_cast<std::int64_t>(1e9 / rate_hz)) : Duration{};
}

// Empty, or what is wrong with it.
std::string set(Arguments& arguments, const Role& role, std::string_view name,
                std::string_view value) {
  if (name == "--at" || (name == "--to" && role.to != Address())) {
    const auto address = Address::parse(value);
    if (!address) return in_quotes(value) + " is no address; write Ladar(3/0) or 'Test(1/2):1'";
    if (name == "--at")
      arguments.at = *address;
    else
      arguments.to = *address;
    return {};
  }
  if (name == "--rate" && role.rate_hz > 0) {
    double rate = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), rate);
    const bool whole = error == std::errc{} && end == value.data() + value.size();
    const bool in_range = rate >= 0.1 && rate <= 1000;
    if (!whole || !in_range) return in_quotes(value) + " is no rate from 0.1 to 1000 Hz";
    arguments.period = period_of(rate);
    return {};
  }
  return std::string(role.name) + " has no option " + in_quotes(name);
}

}  // namespace

Parsed parse_arguments(std::span<const std::string> words) {
  if (words.empty()) return "which component?";
  const auto* const role = std::ranges::find(kRoles, words.front(), &Role::name);
  if (role == kRoles.end()) return "no component " + in_quotes(words.front());
  Arguments arguments{
      .role = words.front(), .at = {}, .to = role->to, .period = period_of(role->rate_hz)};
  for (std::size_t i = 1; i < words.size(); i += 2) {
    if (i + 1 == words.size()) return words[i] + " needs a value";
    if (std::string wrong = set(arguments, *role, words[i], words[i + 1]); !wrong.empty())
      return wrong;
  }
  if (!arguments.at) arguments.at = role->at;
  return arguments;
}

std::string usage() {
  return "usage: tims-demo ladar [--at ADDR] [--rate HZ]      a laser range finder, Ladar(0/0), 75 "
         "Hz\n"
         "       tims-demo viewer [--at ADDR] [--to ADDR]     watches a ladar, prints a line a "
         "second\n"
         "       tims-demo server [--at ADDR]                 Test(0/0): answers with the bytes "
         "reversed\n"
         "       tims-demo client [--at ADDR] [--to ADDR] [--rate HZ]   asks a server, 10 times a "
         "second\n"
         "A small component for the router at $TIMS_ROUTER (default: the host's). --at is its own\n"
         "mailbox, --to whom it talks to: several may run when each has its own.\n";
}

}  // namespace tims::demo

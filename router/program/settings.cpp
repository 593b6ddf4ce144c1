#include "router/program/settings.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <unistd.h>

#include "os/environment.h"

namespace tims::program {
namespace {

config::Host this_host() {
  return {.name = os::host_name(), .uid = ::getuid(), .environment = os::environment()};
}

}  // namespace

Result<config::Loaded> load_configuration(const io::Arguments& arguments) {
  config::Sources sources{.files = {}, .settings = arguments.settings, .host = this_host()};
  if (!arguments.config_path.empty()) {
    auto files = config::read_files(arguments.config_path);
    if (!files) return files.error();
    sources.files = std::move(*files);
  }
  return config::load(sources);
}

core::RouterSettings router_settings(const config::Config& c, std::uint64_t epoch) {
  return {.address =
              Address::of({.system = c.router.system, .instance = c.router.id}, c.address.widths),
          .widths = c.address.widths,
          .classes = c.message.classes,
          .role = c.router.role,
          .epoch = static_cast<std::uint32_t>(epoch),
          .compat_delete = c.tcp.compat_delete,
          .lifesign_interval = c.lifesign.interval,
          .clients_max = c.limits.clients,
          .mailboxes_per_client_max = c.limits.mailboxes_per_client};
}

link::Identity identity(const config::Config& c, std::uint64_t epoch) {
  return {.epoch = epoch,
          .role = c.router.role,
          .system = c.router.system,
          .id = c.router.id,
          .name = std::string_view(c.router.name),
          .widths = c.address.widths,
          .message_max = c.message.bytes_max,
          .classes = c.message.classes.at(c.address.widths)};
}

std::vector<core::StaticRoute> static_routes(const config::Config& c) {
  std::vector<core::StaticRoute> routes;
  routes.reserve(c.routes.size());
  for (const config::Route& route : c.routes) {
    routes.push_back({*AddressPattern::parse(route.match, c.address.widths),
                      std::string_view(route.match), std::string_view(route.via)});
  }
  return routes;
}

std::size_t waiting_bytes(const config::Config& c) {
  constexpr std::size_t kWaitingBytesMin = 256 << 20;
  constexpr std::size_t kFullQueues = 16;
  const std::size_t queue = std::max({c.tcp.queue_bytes, c.http.queue_bytes, c.message.bytes_max});
  return std::max(kWaitingBytesMin, kFullQueues * queue);
}

io::BrowserAccess browser_access(const config::Config& c) {
  return {.names = config::list_of(c.http.names),
          .origins = config::list_of(c.http.origins),
          .login = !c.security.keys.empty()};
}

config::Networks plain_networks(const config::Config& c) {
  return config::Networks::parse(c.tcp.plain).value_or({});
}

core::NewestRule newest_rule(const config::Config& c) {
  core::NewestRule rule{.length_max = c.newest.length_max, .widths = c.address.widths};
  for (const std::string& stream : config::list_of(c.newest.streams)) (void)rule.add(stream);
  return rule;
}

policy::PolicyText policy_text(const config::Loaded& loaded) {
  return config::policy_text(loaded.config, config::rule_places(loaded.origins));
}

policy::Policy policy_of(const config::Loaded& loaded) {
  const AddressWidths& widths = loaded.config.address.widths;
  std::vector<policy::Problem> problems;  // none: the configuration was checked
  auto policy = policy::Policy::compile(policy_text(loaded), widths, problems);
  return policy ? std::move(*policy) : policy::Policy(widths);
}

}  // namespace tims::program

#include "router/io/dds_path.h"

#include <utility>

#include <fmt/core.h>

#include "os/clock.h"
#include "router/io/net/interfaces.h"

namespace tims::io {
namespace {

// Without keys nothing beyond this host is spoken with, unless that was asked for.
std::string interface(const config::Config& config) {
  return config.security.insecure ? "" : "127.0.0.1";
}

DdsSettings settings(const config::Config& config) {
  return {.fleet = config.fleet.name,
          .domain = config.dds.domain,
          .multicast = config.dds.multicast,
          .peers = config::list_of(config.dds.peers),
          .discovery_server = config.dds.server,
          .interface = interface(config),
          .profiles = config.dds.profiles,
          .lease = config.dds.lease,
          .message_max = config.dds.message_max,
          .history = config.dds.history,
          .heartbeat = config.dds.heartbeat};
}

std::vector<link::NetAddress> all_addresses() { return own_addresses({.port = 1}); }

}  // namespace

DdsPath::DdsPath(Loop& loop, Log& log, link::Links& links, const config::Config& config)
    : loop_(loop),
      log_(log),
      links_(links),
      self_{.fleet = std::string_view(config.fleet.name), .who = links.self()},
      engine_(loop, log, settings(config), *this) {}

Result<void> DdsPath::start(std::vector<link::NetAddress> udp) {
  self_.udp = std::move(udp);
  host_ = all_addresses();
  return engine_.start(self_);
}

void DdsPath::network_changed(std::vector<link::NetAddress> udp) {
  std::vector<link::NetAddress> host = all_addresses();
  if (udp == self_.udp && host == host_) return;
  self_.udp = std::move(udp);
  host_ = std::move(host);
  engine_.restart(self_);
}

void DdsPath::on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) {
  links_.on_datagram(os::now(), from, datagram);
}

void DdsPath::on_announced(const link::Announcement& announcement) {
  links_.on_announced(os::now(), announcement);
  links_.for_each([&](const link::Link& link) {
    if (link.paths().is_target(announcement.dds)) engine_.connect(announcement.dds);
  });
}

void DdsPath::on_gone(const link::NetAddress& dds) { links_.on_gone(os::now(), dds); }

void DdsPath::on_state() {
  std::string trouble;
  if (engine_.state() != DdsEngine::State::kUp)
    trouble = fmt::format("{}{}{}", name(engine_.state()), engine_.last_error().empty() ? "" : ": ",
                          engine_.last_error());
  if (!trouble.empty() && trouble != links_.trouble(link::PathKind::kDds))
    log_.warning("dds is " + trouble);
  links_.set_trouble(link::PathKind::kDds, std::move(trouble));
}

void DdsPath::on_turn_end() { loop_.end_turn(os::now()); }

}  // namespace tims::io

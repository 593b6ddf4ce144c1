#include "router/core/routes.h"

#include <algorithm>

namespace tims::core {

bool is_link(const Client* client, LinkKind kind) {
  return client != nullptr && client->info.port == PortKind::kLink &&
         client->info.link.kind == kind;
}

// Messages from routers above or beside are forwarded only downwards, which rules out loops.
bool only_down(const Client* from) {
  return is_link(from, LinkKind::kSuper) || is_link(from, LinkKind::kPeer);
}

void Routes::remove_link(ClientId link) {
  std::erase(links_, link);
  if (uplink_ == link) uplink_ = kNoClient;
}

NextHop Routes::next_hop(const Client* from, Address dest) const {
  NextHop on;
  const auto take = [&](ClientId next, std::uint32_t handle, NextHop::By by) {
    Client* to = clients_.find(next);
    if (to == nullptr) return false;
    if (from != nullptr && to->id == from->id && to->info.port == PortKind::kLink) {
      on.why_not = Outcome::kWouldReturn;
      return false;
    }
    on = {to, handle, by};
    return true;
  };
  if (const Table::Entry* entry = registrations_.find(dest)) {
    const Client* owner = clients_.find(entry->owner);
    if (only_down(from) && only_down(owner)) return {.why_not = Outcome::kWouldReturn};
    take(entry->owner, entry->handle, NextHop::By::kTable);
    return on;
  }
  for (const StaticRoute& route : static_) {
    if (!route.match.matches(dest)) continue;
    if (take(link_named(route.via.view()), 0, NextHop::By::kStatic)) return on;
  }
  if (only_down(from)) return on.why_not == Outcome::kNoRoute ? NextHop{} : on;
  const auto system = dest.fields(widths_).system;
  if (const ClientId peer = peer_router(system); peer && take(peer, 0, NextHop::By::kSystem))
    return on;
  // Includes the own system: an operator's joystick for this robot may be registered at the base.
  take(uplink_, 0, NextHop::By::kUp);
  return on;
}

bool Routes::leads_over_link(const Client& from, Address dest) const {
  const NextHop on = next_hop(&from, dest);
  return on.to != nullptr && on.to->info.port == PortKind::kLink;
}

// The system router of another robot, linked as a peer.
ClientId Routes::peer_router(std::uint32_t system) const {
  for (const ClientId id : links_) {
    const Client& other = *clients_.find(id);
    if (is_link(&other, LinkKind::kPeer) && other.info.link.role == Role::kSystem &&
        other.info.link.system == system)
      return id;
  }
  return kNoClient;
}

ClientId Routes::link_named(std::string_view name) const {
  for (const ClientId id : links_) {
    if (clients_.find(id)->info.link.name.view() == name) return id;
  }
  return kNoClient;
}

bool Routes::may_come_from(const Client& link, Address address) const {
  const ClientInfo::Link& with = link.info.link;
  const auto system = address.fields(widths_).system;
  // From above comes anything but what is here or below.
  if (with.kind == LinkKind::kSuper) {
    const Table::Entry* entry = registrations_.find(address);
    if (entry == nullptr || entry->owner == link.id) return true;
  } else if ((with.role == Role::kTop || system == with.system) &&
             (!with.only || system == *with.only)) {
    return true;
  }
  return std::ranges::any_of(static_, [&](const StaticRoute& route) {
    return route.match.matches(address) && link_named(route.via.view()) == link.id;
  });
}

}  // namespace tims::core

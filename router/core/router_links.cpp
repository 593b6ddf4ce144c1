// Router, the part that knows other routers: which way a message goes on, and what they announce.
#include <algorithm>

#include "router/core/router.h"
#include "wire/header.h"

namespace tims::core {
namespace {

constexpr Duration kLoopEventEvery = std::chrono::seconds(1);

bool is_link(const Client* client, LinkKind kind) {
  return client != nullptr && client->info.port == PortKind::kLink &&
         client->info.link.kind == kind;
}

// What comes from above or beside goes down and nowhere else: so no message goes round.
bool only_down(const Client* from) {
  return is_link(from, LinkKind::kSuper) || is_link(from, LinkKind::kPeer);
}

}  // namespace

// --- The way of a message

Router::Way Router::way(const Client* from, Address dest) const {
  Way on;
  const auto take = [&](ClientId next, std::uint32_t handle, Way::By by) {
    Client* to = clients_.find(next);
    if (to == nullptr) return false;
    if (from != nullptr && to->id == from->id && to->info.port == PortKind::kLink) {
      on.why_not = Outcome::kWouldReturn;
      return false;
    }
    on = {to, handle, by};
    return true;
  };
  if (const Table::Entry* entry = find(dest)) {
    const Client* owner = clients_.find(entry->owner);
    if (only_down(from) && only_down(owner)) return {.why_not = Outcome::kWouldReturn};
    take(entry->owner, entry->handle, Way::By::kTable);
    return on;
  }
  for (const StaticRoute& route : static_routes_) {
    if (!route.match.matches(dest)) continue;
    if (take(link_named(route.via.view()), 0, Way::By::kStatic)) return on;
  }
  if (only_down(from)) return on.why_not == Outcome::kNoRoute ? Way{} : on;
  const auto system = dest.fields(settings_.widths).system;
  if (const ClientId peer = peer_of(system); peer && take(peer, 0, Way::By::kSystem)) return on;
  // Of the own system, too: an operator's joystick for this robot may be registered at the base.
  take(uplink_, 0, Way::By::kUp);
  return on;
}

bool Router::leads_over_link(const Client& from, Address dest) const {
  const Way on = way(&from, dest);
  return on.to != nullptr && on.to->info.port == PortKind::kLink;
}

// The system router of another robot, beside this one.
ClientId Router::peer_of(std::uint32_t system) const {
  for (const ClientId id : links_) {
    const Client& other = *clients_.find(id);
    if (is_link(&other, LinkKind::kPeer) && other.info.link.role == Role::kSystem &&
        other.info.link.system == system)
      return id;
  }
  return kNoClient;
}

ClientId Router::link_named(std::string_view name) const {
  for (const ClientId id : links_) {
    if (clients_.find(id)->info.name.view() == name) return id;
  }
  return kNoClient;
}

bool Router::may_come_from(const Client& link, Address address) const {
  const auto only = link.info.link.only;
  if (!only || address.fields(settings_.widths).system == *only) return true;
  return std::ranges::any_of(static_routes_, [&](const StaticRoute& route) {
    return route.match.matches(address) && link_named(route.via.view()) == link.id;
  });
}

Outcome Router::stop_loop(Time now, const Client* from, const Client& to, const Message& message) {
  if (now >= next_loop_event_) {
    next_loop_event_ = now + kLoopEventEvery;
    happened({.at = now,
              .kind = EventKind::kLoop,
              .address = message.header.dest,
              .client = from == nullptr ? Party{} : from->party(),
              .owner = to.party()});
  }
  return Outcome::kHopLimit;
}

void Router::set_uplink(Time now, ClientId link) {
  if (uplink_ == link) return;
  uplink_ = link;
  happened({.at = now, .kind = EventKind::kUplinkChanged, .client = party(link)});
}

// --- What they announce

std::optional<Origin> Router::told(Address address) const {
  if (address == settings_.address) return registrations_.here();
  const Table::Entry* entry = find(address);
  if (entry == nullptr || address == kTextSink) return std::nullopt;
  const Client& owner = *clients_.find(entry->owner);
  if (only_down(&owner)) return std::nullopt;
  return registrations_.origin(owner, *entry);
}

bool Router::learn(Time now, ClientId link, Address address, const Origin& origin) {
  Client* from = clients_.find(link);
  if (from == nullptr || address == kTextSink) return false;
  const Origin& here = registrations_.here();
  if (origin.router == here.router || origin.hops >= kHopsMax) {
    // Our own mailboxes come back to us, or somebody else's go round; or somebody has our address.
    const bool loop = origin.router != here.router || origin.epoch == here.epoch;
    happened({.at = now,
              .kind = loop ? EventKind::kLoop : EventKind::kDuplicateRouter,
              .address = address,
              .client = from->party(),
              .owner = party_of(*from, origin)});
    return false;
  }
  const Table::Entry* entry = find(address);
  if (entry == nullptr && address != settings_.address) {
    registrations_.add(now, *from, address, origin);
    if (address == origin.router) missing_.found(address);
    happened({.at = now,
              .kind = EventKind::kRegistered,
              .address = address,
              .client = party_of(*from, origin)});
    return true;
  }
  if (entry != nullptr && entry->owner == link) {
    if (this->origin(*entry) == origin) return true;
    forget(now, link, address);
    return learn(now, link, address, origin);
  }
  registrations_.stop_waiting(address, link);
  registrations_.wait(address, {link, origin});
  duplicate(now, *from, address, origin);
  return true;
}

// Another link, or a client here, has the address already.
void Router::duplicate(Time now, const Client& link, Address address, const Origin& origin) {
  const Table::Entry* entry = find(address);
  const Client* owner = entry == nullptr ? nullptr : clients_.find(entry->owner);
  if (owner != nullptr && owner->info.port == PortKind::kLink) {
    const Origin current = this->origin(*entry);
    if (current.same_router(origin)) {
      // Two ways to one router: the shorter.
      if (origin.hops >= current.hops) return;
      registrations_.wait(address, {owner->id, current});
      Client& loser = *clients_.find(owner->id);
      registrations_.remove(loser, address);
      learn_again(now, address);
      return;
    }
    // The same router after a restart: the old announcement is on its way out.
    if (current.router == origin.router) return;
    happened({.at = now,
              .kind = EventKind::kDuplicateAddress,
              .address = address,
              .client = party_of(link, origin),
              .owner = party_of(*owner, current)});
    return;
  }
  happened({.at = now,
            .kind = EventKind::kDuplicateAddress,
            .address = address,
            .client = party_of(link, origin),
            .owner = owner == nullptr ? Party{} : owner->party()});
}

// The address has become free: who has waited for it?
void Router::learn_again(Time now, Address address) {
  if (address == kTextSink) next_text_reader(now);
  if (find(address) != nullptr) return;
  const auto next = registrations_.take_waiting(address);
  if (next) learn(now, next->link, address, next->origin);
}

void Router::forget(Time now, ClientId link, Address address) {
  Client* from = clients_.find(link);
  if (from == nullptr || registrations_.stop_waiting(address, link)) return;
  const Table::Entry* entry = find(address);
  if (entry == nullptr || entry->owner != link) return;
  const Party owner = party_of(*from, origin(*entry));
  registrations_.remove(*from, address);
  happened({.at = now,
            .kind = EventKind::kWithdrawn,
            .address = address,
            .client = owner,
            .owner = owner});
  learn_again(now, address);
}

void Router::forget_all(Time now, ClientId link) {
  Client* from = clients_.find(link);
  if (from == nullptr) return;
  registrations_.stop_waiting(link);
  withdraw_all(now, *from);
}

// The nearest first. A router announces its own address as it does those of its mailboxes.
std::vector<Address> Router::routers_behind(const Client& link) const {
  std::vector<Address> routers;
  if (link.info.port != PortKind::kLink) return routers;
  for (const OwnedMailbox& mailbox : link.mailboxes) {
    if (origin(*find(mailbox.address)).router == mailbox.address)
      routers.push_back(mailbox.address);
  }
  std::ranges::sort(routers, {}, [&](Address router) { return origin(*find(router)).hops; });
  return routers;
}

// The link has gone, and with it those that no other link brings.
void Router::miss(Time now, const Client& link, const std::vector<Address>& routers) {
  for (const Address router : routers) {
    if (find(router) != nullptr) continue;
    missing_.add(
        {.router = router, .behind = link.info.link.router, .via = link.info.name, .since = now});
  }
}

std::optional<Origin> Router::announced(ClientId link, Address address) const {
  const Table::Entry* entry = find(address);
  if (entry != nullptr && entry->owner == link) return origin(*entry);
  return registrations_.waiting_origin(address, link);
}

// A mailbox's owner behind a link: the link's name, and the router it lives at.
Party Router::party_of(const Client& link, const Origin& origin) const {
  Party party = link.party();
  party.peer = Text<55>(origin.router.to_string(settings_.widths));
  return party;
}

void Router::on_undelivered(Time now, ClientId link, const Header& header, Outcome outcome) {
  const Count one{1, header.length};
  messages_.add(PortKind::kLink, settings_.classes.of(header), outcome, one);
  drops_.add(now);
  count_dropped(clients_.find(link), one);
  if (header.type <= 0) return;
  // As if it had been refused at once, only later.
  const Way back = way(nullptr, header.src);
  if (back.to == nullptr) return;
  answer_not_available(receiver_of(*back.to, back.handle), header);
}

}  // namespace tims::core

#include "router/core/router.h"

#include <algorithm>
#include <utility>

#include "wire/header.h"

namespace tims::core {
namespace {

constexpr std::uint8_t kOwnFlags =
    flag::kStream | flag::kTrace | flag::kTellIfGone | flag::kTellWhy;

// Nobody on the way knows where it should go: the sender of a command is told.
bool is_no_way(Outcome outcome) {
  return outcome == Outcome::kNoRoute || outcome == Outcome::kWouldReturn ||
         outcome == Outcome::kHopLimit;
}

// That nobody owns the destination. Original programs set our flags as they like.
bool wants_to_know(const Client& sender, const Header& header) {
  const bool asks = (header.flags & flag::kTellIfGone) != 0;
  return header.type > 0 || (asks && sender.info.port != PortKind::kTcp);
}

EventKind kind_of(Registration::Status status) {
  switch (status) {
    case Registration::Status::kOk:
      return EventKind::kRegistered;
    case Registration::Status::kTooMany:
      return EventKind::kMailboxLimit;
    default:
      return EventKind::kAddressRefused;
  }
}

}  // namespace

Router::Router(const RouterSettings& settings, HashSeed seed, Sink& sink)
    : settings_(settings),
      sink_(sink),
      registrations_(seed),
      lifesigns_(settings.lifesign_interval) {
  const Origin here{settings.address, settings.epoch, 0};
  registrations_.set_here(here);
  registrations_.below().added(settings.address, here);
}

void Router::configure(Time now, const RouterSettings& settings) {
  const RouterSettings old = std::exchange(settings_, settings);
  settings_.address = old.address;
  settings_.widths = old.widths;
  settings_.classes = old.classes;
  settings_.role = old.role;
  settings_.epoch = old.epoch;
  lifesigns_.set_interval(now, settings.lifesign_interval);
}

// --- Clients and mailboxes

ClientId Router::connect(Time now, const ClientInfo& info) {
  if (!has_room(info.port)) {
    refuse(now, info, CloseReason::kTooManyClients);
    return kNoClient;
  }
  Client& client = clients_.add(info, now);
  if (info.lifesign) lifesigns_.watch(now, client);
  const bool link = info.port == PortKind::kLink;
  if (link) links_.push_back(client.id);
  happened({.at = now,
            .kind = link ? EventKind::kLinkUp : EventKind::kClientCame,
            .client = client.party()});
  return client.id;
}

bool Router::has_room(PortKind port) const {
  if (port == PortKind::kLink) return true;
  const std::size_t pages = clients_.size(PortKind::kWebSocket);
  const std::size_t guests = clients_.size(PortKind::kTcp) + pages;
  const std::size_t quarter = settings_.clients_max / 4;
  if (clients_.size(PortKind::kLocal) + guests >= settings_.clients_max) return false;
  if (port == PortKind::kLocal) return true;
  if (port == PortKind::kWebSocket && pages >= std::max<std::size_t>(quarter, 1)) return false;
  return guests < settings_.clients_max - quarter;
}

void Router::refuse(Time now, const ClientInfo& info, CloseReason reason) {
  happened({.at = now,
            .kind = EventKind::kClientRefused,
            .reason = reason,
            .client = {.port = info.port, .pid = info.pid, .name = info.name, .peer = info.peer}});
}

void Router::disconnect(Time now, ClientId id, CloseReason reason) {
  Client* client = clients_.find(id);
  if (client == nullptr) return;
  std::vector<Address> behind = routers_behind(*client);
  // It said goodbye: nobody misses it. Those behind it did not.
  if (reason == CloseReason::kShutdown) std::erase(behind, client->info.link.router);
  registrations_.stop_waiting(id);
  withdraw_all(now, *client);
  miss(now, *client, behind);
  lifesigns_.unwatch(*client);
  std::erase(links_, id);
  if (uplink_ == id) uplink_ = kNoClient;
  record_end(now, *client, reason);
  clients_.remove(id);
}

Registration Router::register_mailbox(Time now, ClientId id, Address address,
                                      std::uint32_t handle) {
  using Status = Registration::Status;
  Client* client = clients_.find(id);
  if (client == nullptr || client->info.port == PortKind::kLink)
    return {Status::kNoSuchClient, kNoClient};
  Registration result;
  const bool shares = may_share(*client, address);
  if (const Table::Entry* entry = find(address); entry != nullptr && !shares) {
    result = {Status::kAddressInUse, entry->owner};
  } else if (address == settings_.address) {
    result = {Status::kAddressInUse, kNoClient};
  } else if (client->mailboxes.size() >= settings_.mailboxes_per_client_max) {
    result = {Status::kTooMany, kNoClient};
  }
  if (result.status == Status::kOk && shares) {
    if (text_readers_.empty()) sink_.moved(address);
    text_readers_.push_back({id, handle});
  } else if (result.status == Status::kOk) {
    registrations_.add(now, *client, address, handle);
  }
  happened({.at = now,
            .kind = kind_of(result.status),
            .address = address,
            .client = client->party(),
            .owner = party(result.owner)});
  return result;
}

Removal Router::remove_mailbox(Time now, ClientId by, Address address) {
  const Client* client = clients_.find(by);
  const Table::Entry* entry = find(address);
  if (client == nullptr || entry == nullptr) return Removal::kUnknown;
  if (address == kTextSink && stop_sharing(by)) {
    happened({.at = now,
              .kind = EventKind::kWithdrawn,
              .address = address,
              .client = client->party(),
              .owner = client->party()});
    return Removal::kOk;
  }
  Client& owner = *clients_.find(entry->owner);
  const bool allowed = may_delete(*client, owner);
  happened({.at = now,
            .kind = allowed ? EventKind::kWithdrawn : EventKind::kDeleteRefused,
            .address = address,
            .client = client->party(),
            .owner = owner.party()});
  if (!allowed) return Removal::kNotOwner;
  registrations_.remove(owner, address);
  learn_again(now, address);
  return Removal::kOk;
}

void Router::purge(Time now, ClientId id) {
  if (Client* client = clients_.find(id)) withdraw_all(now, *client);
}

// --- Messages

Outcome Router::on_message(Time now, ClientId from, Message& message) {
  Client* sender = clients_.find(from);
  if (sender == nullptr) return Outcome::kClientGone;
  sender->in.add(message.bytes.size());
  // The sender may be gone after this.
  const PortKind port = sender->info.port;
  const Outcome outcome = dispatch(now, *sender, message);
  if (!taken(outcome)) drops_.add(now);
  messages_.add(port, settings_.classes.of(message.header),
                outcome == Outcome::kMailboxReplaced ? Outcome::kDelivered : outcome,
                message.bytes.size());
  return outcome;
}

Outcome Router::answer(Time now, ClientId asker, Message& message) {
  Outcome outcome = Outcome::kClientGone;
  if (!is_for_router(message.header)) {
    outcome = forward(now, nullptr, message);
  } else if (Client* client = clients_.find(asker)) {
    outcome = hand_over(now, receiver_of(*client), *client, message);
  }
  if (!taken(outcome)) drops_.add(now);
  messages_.add(PortKind::kRouter, settings_.classes.of(message.header),
                outcome == Outcome::kMailboxReplaced ? Outcome::kDelivered : outcome,
                message.bytes.size());
  return outcome;
}

Outcome Router::dispatch(Time now, Client& sender, Message& message) {
  const Header& header = message.header;
  const bool local = sender.info.port == PortKind::kLocal;
  const bool link = sender.info.port == PortKind::kLink;
  if (is_for_router(header) && link) return Outcome::kMalformedCommand;
  if (link && !may_come_from(sender, header.src)) return Outcome::kForgedSource;
  if (is_for_router(header) && !local) return carry_out(now, sender, message);

  const std::optional<std::uint32_t> own = handle_of(sender, header.src);
  const bool forged = !own;
  if (forged && local) return Outcome::kForgedSource;
  if (forged && !link) count(EventKind::kForgedSourceTolerated);
  const std::uint32_t handle = forged || link ? 0 : *own;

  if (header.dest == settings_.address) return for_router_itself(sender, handle, message);
  if (header.type == type::kAdminRequest && !local && !link && is_router(header.dest) &&
      !sink_.may_ask(sender.id, message)) {
    sink_.admin(sender.id, message);
    return Outcome::kHandled;
  }
  const Outcome outcome = forward(now, &sender, message);
  const bool lost_command =
      header.type > 0 && !taken(outcome) && leads_over_link(sender, header.dest);
  if (lost_command || (is_no_way(outcome) && wants_to_know(sender, header)))
    answer_not_available(receiver_of(sender, handle), header);
  return outcome;
}

std::optional<std::uint32_t> Router::handle_of(const Client& owner, Address address) const {
  const Table::Entry* entry = find(address);
  if (entry != nullptr && entry->owner == owner.id) return entry->handle;
  if (address != kTextSink) return std::nullopt;
  const auto reader = std::ranges::find(text_readers_, owner.id, &TextReader::client);
  if (reader == text_readers_.end()) return std::nullopt;
  return reader->handle;
}

// Routers have a class of their own, 0.
bool Router::is_router(Address address) const {
  return address.fields(settings_.widths).class_id ==
         settings_.address.fields(settings_.widths).class_id;
}

Receiver Router::receiver_of(const Client& client, std::uint32_t handle) {
  return {
      .client = client.id, .port = client.info.port, .token = client.info.token, .handle = handle};
}

Outcome Router::forward(Time now, Client* from, Message& message) {
  Way on = way(from, message.header.dest);
  if (on.to == nullptr) {
    const bool unread = message.header.dest == kTextSink && message.header.type <= 0;
    return unread && on.why_not == Outcome::kNoRoute ? Outcome::kUnread : on.why_not;
  }
  if (message.header.dest == kTextSink && shares_texts()) {
    if (message.header.type <= 0) {
      copy_text(now, message);
    } else if (on.to->info.port != PortKind::kLocal) {
      on = who_keeps_texts(on);
    }
  }
  // Original programs set these bits as they like and know nothing of what they mean to us; among
  // themselves they keep them.
  const bool original = from != nullptr && from->info.port == PortKind::kTcp;
  const bool to_original = on.to->info.port == PortKind::kTcp;
  if ((message.header.flags & flag::kTrace) != 0 && from != nullptr && !original)
    sink_.traced(from->id, on.to->id, message);
  if (original != to_original) message.header.flags &= static_cast<std::uint8_t>(~kOwnFlags);
  if (on.to->info.port == PortKind::kLink && message.hops >= kHopsMax)
    return stop_loop(now, from, *on.to, message);
  return hand_over(now, receiver_of(*on.to, on.handle), *on.to, message);
}

// To all who have the sink of texts but the first. Flags of our own are nothing that texts need.
void Router::copy_text(Time now, Message& message) {
  message.header.flags &= static_cast<std::uint8_t>(~kOwnFlags);
  for (const TextReader& reader : text_readers_) {
    Client& client = *clients_.find(reader.client);
    const Outcome outcome = hand_over(now, receiver_of(client, reader.handle), client, message);
    if (taken(outcome)) continue;
    messages_.add(client.info.port, message.header.priority, outcome, message.bytes.size());
    drops_.add(now);
  }
}

// A command to the sink is for a log of our own; the original's windows know texts only.
Router::Way Router::who_keeps_texts(const Way& otherwise) const {
  for (const TextReader& reader : text_readers_) {
    Client* client = clients_.find(reader.client);
    if (client->info.port == PortKind::kLocal) return {client, reader.handle, Way::By::kTable};
  }
  return otherwise;
}

Outcome Router::hand_over(Time now, const Receiver& to, Client& receiver, Message& message) {
  Header& header = message.header;
  header.flags = static_cast<std::uint8_t>((header.flags & ~flag::kHeaderLittleEndian) |
                                           (flag::kNativeOrder & flag::kHeaderLittleEndian));
  wire::encode_header(header, message.bytes.first<kHeaderSize>());
  const Outcome outcome = sink_.deliver(to, message);
  const Count one{1, message.bytes.size()};
  if (!taken(outcome)) {
    count_dropped(&receiver, one);
    return outcome;
  }
  receiver.out.add(one.bytes);
  if (outcome == Outcome::kMailboxReplaced) {
    // How long the older message was is not known, and its priority was not higher.
    const Count older{1, 0};
    messages_.add(to.port, settings_.classes.of(header), outcome, older);
    count_dropped(&receiver, older);
    drops_.add(now);
  }
  return outcome;
}

Outcome Router::for_router_itself(Client& sender, std::uint32_t handle, const Message& message) {
  if (message.header.type == type::kAdminRequest) {
    sink_.admin(sender.id, message);
    return Outcome::kHandled;
  }
  if (message.header.type > 0) {
    sink_.reply(receiver_of(sender, handle), wire::reply_to(message.header, type::kError));
  }
  return Outcome::kUnknownCommand;
}

void Router::answer_not_available(const Receiver& to, const Header& request) {
  count(EventKind::kNotAvailable);
  sink_.reply(to, wire::reply_to(request, type::kNotAvailable));
}

void Router::on_lost(Time now, PortKind port, ClientId client, Outcome outcome,
                     const Losses& losses) {
  Client* receiver = clients_.find(client);
  for (std::size_t i = 0; i < losses.size(); ++i) {
    if (losses[i].messages == 0) continue;
    messages_.add(port, i, outcome, losses[i]);
    drops_.add(now, losses[i].messages);
    count_dropped(receiver, losses[i]);
  }
}

void Router::on_lost(Time now, PortKind port, ClientId client, Outcome outcome,
                     std::uint8_t priority, std::uint64_t size) {
  Losses losses{};
  losses[settings_.classes.of(priority)] = {1, size};
  on_lost(now, port, client, outcome, losses);
}

void Router::count_dropped(Client* receiver, const Count& count) {
  if (receiver == nullptr) return;
  receiver->dropped.messages += count.messages;
  receiver->dropped.bytes += count.bytes;
}

// --- What happened

bool Router::may_share(const Client& client, Address address) const {
  const Table::Entry* entry = address == kTextSink ? find(address) : nullptr;
  return entry != nullptr && !handle_of(client, address) &&
         text_readers_.size() + 1 < kTextReadersMax;
}

bool Router::stop_sharing(ClientId client) {
  return std::erase_if(text_readers_, [&](const auto& r) { return r.client == client; }) > 0;
}

// The first has gone: the next takes its place.
void Router::next_text_reader(Time now) {
  if (text_readers_.empty() || find(kTextSink) != nullptr) return;
  const TextReader next = text_readers_.front();
  text_readers_.erase(text_readers_.begin());
  registrations_.add(now, *clients_.find(next.client), kTextSink, next.handle);
}

void Router::withdraw_all(Time now, Client& client) {
  stop_sharing(client.id);
  const Party owner = client.party();
  while (!client.mailboxes.empty()) {
    const Address address = registrations_.remove_last(client);
    happened({.at = now,
              .kind = EventKind::kWithdrawn,
              .address = address,
              .client = owner,
              .owner = owner});
    learn_again(now, address);
  }
}

void Router::record_end(Time now, const Client& client, CloseReason reason) {
  Event event{.at = now, .reason = reason, .client = client.party()};
  if (client.info.port == PortKind::kLink) {
    event.kind = EventKind::kLinkDown;
    return happened(event);
  }
  switch (reason) {
    case CloseReason::kWatchdog:
      event.kind = EventKind::kWatchdogClosed;
      break;
    case CloseReason::kTooShort:
    case CloseReason::kTooLong:
    case CloseReason::kBadRecord:
      event.kind = EventKind::kProtocolError;
      break;
    default:
      event.kind = EventKind::kClientWent;
      break;
  }
  happened(event);
}

void Router::happened(const Event& event) {
  count(event.kind);
  sink_.event(events_.add(event));
}

Party Router::party(ClientId id) const {
  const Client* client = clients_.find(id);
  return client == nullptr ? Party{} : client->party();
}

}  // namespace tims::core

#include "router/core/router.h"

#include <algorithm>
#include <string>
#include <utility>

#include "router/core/router_events.h"
#include "tims/origin.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::core {
namespace {

constexpr std::uint8_t kOwnFlags =
    flag::kStream | flag::kTrace | flag::kReportIfGone | flag::kReportReason;

// True when the sender must be notified that the destination is not registered.
bool wants_notification(const Client& sender, const Header& header) {
  const bool asks = (header.flags & flag::kReportIfGone) != 0;
  return header.type > 0 || (asks && !sender.is_original());
}

// Programs of this host use the local port; the router itself has no client.
bool is_foreign(const Client* sender) {
  return sender != nullptr && sender->info.port != PortKind::kLocal;
}

constexpr Duration kLoopEventEvery = std::chrono::seconds(1);
constexpr Duration kRefusalEventEvery = std::chrono::seconds(1);

}  // namespace

Router::Router(const RouterSettings& settings, HashSeed seed, RouterHooks& hooks)
    : settings_(settings),
      hooks_(hooks),
      registrations_(seed, tims::text_sink(settings.widths)),
      routes_(clients_, registrations_, settings.widths),
      lifesigns_(settings.lifesign_interval) {
  settings_.classes = settings.classes.at(settings.widths);
  const Origin here{settings.address, settings.epoch, 0};
  registrations_.set_here(here);
  registrations_.exported_table().added(settings.address, here);
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

// --- Ports

void Router::flush(Time now) {
  for (Port* port : ports_) {
    if (port != nullptr) port->flush(now);
  }
}

void Router::stop_accepting() {
  for (Port* port : ports_) {
    if (port != nullptr) port->stop_accepting();
  }
}

bool Router::drained() const {
  return std::ranges::all_of(ports_,
                             [](const Port* port) { return port == nullptr || port->drained(); });
}

std::uint64_t Router::queued_bytes(PortKind kind, std::uint32_t token) const {
  const Port* port = ports_[static_cast<std::size_t>(kind)];
  return port == nullptr ? 0 : port->queued_bytes(token);
}

const StreamCounters* Router::streams(PortKind kind, std::uint32_t token) const {
  const Port* port = ports_[static_cast<std::size_t>(kind)];
  return port == nullptr ? nullptr : port->streams(token);
}

// --- Clients and mailboxes

ClientId Router::connect(Time now, const ClientInfo& info) {
  if (!has_room(info.port)) {
    refuse(now, info, CloseReason::kTooManyClients);
    return kNoClient;
  }
  Client& client = clients_.add(info, now);
  gate_.enter(now, client);
  if (info.lifesign) lifesigns_.watch(now, client);
  const bool link = info.port == PortKind::kLink;
  if (link) routes_.add_link(client.id);
  happened(now, link ? EventKind::kLinkUp : EventKind::kClientCame, Address(), client.peer());
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
            .client = {
                .port = info.port, .pid = info.pid, .name = info.name, .endpoint = info.endpoint}});
}

void Router::disconnect(Time now, ClientId id, CloseReason reason) {
  Client* client = clients_.find(id);
  if (client == nullptr) return;
  std::vector<Address> behind = routers_behind(*client);
  // It sent CLOSE before it ended, so it is not missing. The routers behind it did not.
  if (reason == CloseReason::kShutdown) std::erase(behind, client->info.link.router);
  registrations_.stop_waiting(id);
  withdraw_all(now, *client);
  miss(now, *client, behind);
  lifesigns_.unwatch(*client);
  if (!leases_.empty()) ended(now, leases_.end_of(id));
  routes_.remove_link(id);
  record_end(now, *client, reason);
  gate_.leave(now, *client);
  clients_.remove(id);
}

void Router::rename_link(Time now, ClientId link, std::string_view name,
                         const policy::Subject& subject) {
  Client* client = clients_.find(link);
  if (client == nullptr) return;
  const Text<64> former = client->info.link.name;
  gate_.leave(now, *client);
  client->info.name = name;
  client->info.link.name = name;
  client->info.subject = subject;
  gate_.enter(now, *client);
  happened({.at = now,
            .kind = EventKind::kLinkRenamed,
            .client = client->peer(),
            .text = former.view()});
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
    if (text_readers_.empty()) {
      for (Port* port : ports_)
        if (port != nullptr) port->moved(address);
    }
    text_readers_.push_back({id, handle});
  } else if (result.status == Status::kOk) {
    registrations_.add(now, *client, address, handle);
  }
  happened(now, kind_of(result.status), address, client->peer(), peer(result.owner));
  return result;
}

Removal Router::remove_mailbox(Time now, ClientId by, Address address) {
  const Client* client = clients_.find(by);
  const Table::Entry* entry = find(address);
  if (client == nullptr || entry == nullptr) return Removal::kUnknown;
  if (address == text_sink() && stop_sharing(by)) {
    happened(now, EventKind::kWithdrawn, address, client->peer(), client->peer());
    return Removal::kOk;
  }
  Client& owner = *clients_.find(entry->owner);
  const bool allowed = may_delete(*client, owner);
  happened(now, allowed ? EventKind::kWithdrawn : EventKind::kDeleteRefused, address,
           client->peer(), owner.peer());
  if (!allowed) return Removal::kNotOwner;
  registrations_.remove(owner, address);
  learn_again(now, address);
  return Removal::kOk;
}

// --- Messages

Outcome Router::on_message(Time now, ClientId from, Message& message) {
  Client* sender = clients_.find(from);
  if (sender == nullptr) return Outcome::kClientGone;
  sender->in.add(message.bytes.size());
  // The sender may be removed during dispatch.
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
  const bool may_not = link && !routes_.may_come_from(sender, header.src);
  // Who uses an address of another system there would wait for an answer in vain.
  if (may_not && header.type > 0 && sender.info.link.kind != LinkKind::kSuper)
    answer_not_available(now, receiver_of(sender, 0), header);
  if (may_not) return Outcome::kForgedSource;
  if (is_for_router(header) && !local) return carry_out(now, sender, message);

  const std::optional<std::uint32_t> own = handle_of(sender, header.src);
  const bool forged = !own;
  if (forged && (local || (sender.is_judged() && !link))) return Outcome::kForgedSource;
  const std::uint32_t handle = forged || link ? 0 : *own;
  if (is_about_streams(header) && !names_own_mailbox(sender, message)) {
    answer_not_available(now, receiver_of(sender, handle), header);
    return Outcome::kForgedSource;
  }
  if (forged && !link) count(EventKind::kForgedSourceTolerated);

  if (const auto stopped = judge(now, sender, handle, message)) return *stopped;
  if (own && newest_ != nullptr && newest_->wants(header)) newest_->keep(now, message);
  if (const DrivingLease* lease =
          leases_.against(message, sender.id, own.has_value(), link, settings_.widths))
    return refuse_to_drive(now, sender, handle, message, *lease);
  if (header.dest == settings_.address) return for_router_itself(now, sender, handle, message);
  if (header.type == type::kAdminRequest && !local && !link && is_router(header.dest) &&
      !hooks_.may_ask(sender.id, message)) {
    hooks_.admin(now, sender.id, message);
    return Outcome::kHandled;
  }
  const Outcome outcome = forward(now, &sender, message);
  const bool lost_command =
      header.type > 0 && !taken(outcome) && routes_.leads_over_link(sender, header.dest);
  if (lost_command || (is_unroutable(outcome) && wants_notification(sender, header)))
    answer_not_available(now, receiver_of(sender, handle), header);
  return outcome;
}

std::optional<std::uint32_t> Router::handle_of(const Client& owner, Address address) const {
  const Table::Entry* entry = find(address);
  if (entry != nullptr && entry->owner == owner.id) return entry->handle;
  if (address != text_sink()) return std::nullopt;
  const auto reader = std::ranges::find(text_readers_, owner.id, &TextReader::client);
  if (reader == text_readers_.end()) return std::nullopt;
  return reader->handle;
}

// Who asks for a stream names its receiver: nobody may have it sent to others.
bool Router::names_own_mailbox(const Client& sender, const Message& message) const {
  const auto mailbox = data_mailbox(message);
  if (!mailbox) return true;
  if (sender.info.port == PortKind::kLink) return routes_.may_come_from(sender, *mailbox);
  return !sender.is_judged() || handle_of(sender, *mailbox);
}

// Addresses of routers have class 0, which is reserved for them.
bool Router::is_router(Address address) const {
  return address.fields(settings_.widths).class_id ==
         settings_.address.fields(settings_.widths).class_id;
}

Receiver Router::receiver_of(const Client& client, std::uint32_t handle) {
  return {
      .client = client.id, .port = client.info.port, .token = client.info.token, .handle = handle};
}

Outcome Router::forward(Time now, Client* from, Message& message) {
  NextHop on = routes_.next_hop(from, message.header.dest);
  if (on.to == nullptr) {
    const bool unread = message.header.dest == text_sink() && message.header.type <= 0;
    return unread && on.why_not == Outcome::kNoRoute ? Outcome::kUnread : on.why_not;
  }
  if (message.header.dest == text_sink() && shares_texts()) {
    if (message.header.type <= 0) {
      copy_text(now, message);
    } else if (on.to->info.port != PortKind::kLocal) {
      on = local_text_reader(on);
    }
  }
  // Between original programs the bits pass unchanged.
  const bool original = from != nullptr && from->is_original();
  if ((message.header.flags & flag::kTrace) != 0 && from != nullptr && !original)
    hooks_.traced(from->id, on.to->id, message);
  if (original != on.to->is_original())
    message.header.flags &= static_cast<std::uint8_t>(~kOwnFlags);
  if (on.to->info.port == PortKind::kLocal)
    message.header = marked_foreign(message.header, is_foreign(from));
  if (on.to->info.port == PortKind::kLink && message.hops >= kHopsMax)
    return stop_loop(now, from, *on.to, message);
  return hand_over(now, receiver_of(*on.to, on.handle), *on.to, message);
}

// Delivers the text to all owners of the sink except the first. Texts do not need the extension
// flags.
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

// A command to the sink is meant for our own log program; the original's windows accept texts
// only.
NextHop Router::local_text_reader(const NextHop& otherwise) const {
  for (const TextReader& reader : text_readers_) {
    Client* client = clients_.find(reader.client);
    if (client->info.port == PortKind::kLocal) return {client, reader.handle, NextHop::By::kTable};
  }
  return otherwise;
}

Outcome Router::hand_over(Time now, const Receiver& to, Client& receiver, Message& message) {
  Header& header = message.header;
  header.flags = static_cast<std::uint8_t>((header.flags & ~flag::kHeaderLittleEndian) |
                                           (flag::kNativeOrder & flag::kHeaderLittleEndian));
  wire::encode_header(header, message.bytes.first<kHeaderSize>());
  const Outcome outcome = port_of(to).deliver(now, to, message);
  if (taken(outcome)) gate_.delivered(now, receiver, message);
  const Count one{1, message.bytes.size()};
  if (!taken(outcome)) {
    count_dropped(&receiver, one);
    return outcome;
  }
  receiver.out.add(one.bytes);
  if (outcome == Outcome::kMailboxReplaced) {
    // The length of the replaced message is unknown; its priority was not higher.
    const Count older{1, 0};
    messages_.add(to.port, settings_.classes.of(header), outcome, older);
    count_dropped(&receiver, older);
    drops_.add(now);
  }
  return outcome;
}

Outcome Router::for_router_itself(Time now, Client& sender, std::uint32_t handle,
                                  const Message& message) {
  if (message.header.type == type::kAdminRequest) {
    hooks_.admin(now, sender.id, message);
    return Outcome::kHandled;
  }
  if (message.header.type == type::kAdminReply) return Outcome::kHandled;  // it knows who drives
  if (message.header.type > 0) {
    const Receiver asker = receiver_of(sender, handle);
    port_of(asker).reply(now, asker, wire::reply_to(message.header, type::kError));
  }
  return Outcome::kUnknownCommand;
}

void Router::answer_not_available(Time now, const Receiver& to, const Header& request) {
  count(EventKind::kNotAvailable);
  port_of(to).reply(now, to, wire::reply_to(request, type::kNotAvailable));
}

void Router::on_lost(Time now, PortKind port, ClientId client, Outcome outcome,
                     const LossCounts& losses) {
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
  LossCounts losses{};
  losses[settings_.classes.of(priority)] = {1, size};
  on_lost(now, port, client, outcome, losses);
}

void Router::count_dropped(Client* receiver, const Count& count) {
  if (receiver == nullptr) return;
  receiver->dropped.messages += count.messages;
  receiver->dropped.bytes += count.bytes;
}

// --- policy

std::optional<Outcome> Router::judge(Time now, Client& sender, std::uint32_t handle,
                                     Message& message) {
  using What = policy::Verdict::What;
  if (gate_.passes(sender, message)) return std::nullopt;
  const Header& header = message.header;
  const bool asks =
      header.type == type::kAdminRequest && (is_router(header.dest) || is_for_router(header));
  const policy::Right right = asks ? hooks_.right_of(message) : policy::Right::kNone;
  const bool asks_here = is_for_router(header) || header.dest == settings_.address;
  if (asks_here && right == policy::Right::kLook && hooks_.writes_rules(sender.info))
    return std::nullopt;
  const policy::Verdict verdict = gate_.judge(now, sender, message, right);
  const bool passes = verdict.what == What::kPass;
  if (verdict.report)
    happened(judged(now, passes ? EventKind::kObserved : EventKind::kDenied, header, sender.peer(),
                    gate_.text_of(verdict.rule, sender)));
  if (passes) return std::nullopt;
  if (verdict.what == What::kThinned) return Outcome::kThinned;
  if ((header.flags & flag::kTrace) != 0)
    hooks_.trace_denied(sender.id, message, gate_.text_of(verdict.rule, sender));
  if (asks)
    hooks_.deny_admin(sender.id, message, gate_.text_of(verdict.rule, sender));
  else if (header.type > 0)
    answer_not_available(now, receiver_of(sender, handle), header);
  return Outcome::kDenied;
}

void Router::set_policy(Time now, policy::Policy policy) {
  std::vector<ClientId> free;
  clients_.for_each([&](const Client& client) {
    if (client.info.port == PortKind::kLocal && !client.is_judged()) free.push_back(client.id);
  });
  gate_.enforcer()->set(now, std::move(policy));
  happened({.at = now, .kind = EventKind::kPolicyChanged});
  for (const ClientId id : free)
    if (Client* client = clients_.find(id); client->is_judged())
      give_up(now, *client, CloseReason::kJudged);
}

bool Router::is_direct(const Table::Entry& entry) const {
  const Client* owner = clients_.find(entry.owner);
  if (owner == nullptr || owner->info.port != PortKind::kLocal || owner->is_judged()) return false;
  if (leases_.empty()) return true;
  const Address::Fields at = entry.address.fields(settings_.widths);
  return !is_driven_class(at.class_id) || leases_.find(at.system) == nullptr;
}

void Router::report_denials(Time now) {
  for (const policy::DenialReport& report : gate_.enforcer()->take_reports(now))
    happened(denied(now, report));
}

// --- driving leases

// Programs of this host send such commands through the router while somebody has the lease.
void Router::guard_driven(std::uint32_t robot) {
  clients_.for_each([&](const Client& client) {
    if (client.info.port != PortKind::kLocal) return;
    for (const OwnedMailbox& mailbox : client.mailboxes) {
      const Address::Fields at = mailbox.address.fields(settings_.widths);
      if (at.system == robot && is_driven_class(at.class_id))
        ports_[static_cast<std::size_t>(PortKind::kLocal)]->moved(mailbox.address);
    }
  });
}

LeaseResult Router::change_lease(Time now, ClientId from, LeaseVerb verb,
                                 const DrivingLease& holder) {
  DrivingLease lease = holder;
  lease.client = peer(from);
  const DrivingLeases::Change change = leases_.change(now, verb, lease);
  if (change.ended) ended(now, {*change.ended});
  if (change.began) guard_driven(lease.robot);
  if (change.began) happened(lease_taken(now, lease));
  return change.result;
}

void Router::ended(Time now, const std::vector<DrivingLeases::Ended>& leases) {
  for (const DrivingLeases::Ended& lease : leases) happened(lease_ended(now, lease));
}

// A stick sends many times a second: of its refusals, one event a second.
Outcome Router::refuse_to_drive(Time now, Client& sender, std::uint32_t handle,
                                const Message& message, const DrivingLease& lease) {
  if (now >= next_refusal_event_) {
    next_refusal_event_ = now + kRefusalEventEvery;
    happened(driving_refused(now, message.header, sender.peer(), lease));
  }
  if (message.header.type > 0) {
    const Receiver asker = receiver_of(sender, handle);
    port_of(asker).reply(now, asker, wire::reply_to(message.header, type::kError));
  }
  return Outcome::kNoLease;
}

// --- events

bool Router::may_share(const Client& client, Address address) const {
  const Table::Entry* entry = address == text_sink() ? find(address) : nullptr;
  return entry != nullptr && !handle_of(client, address) &&
         text_readers_.size() + 1 < kTextReadersMax;
}

bool Router::stop_sharing(ClientId client) {
  return std::erase_if(text_readers_, [&](const auto& r) { return r.client == client; }) > 0;
}

// The first owner has gone: the next one takes its place.
void Router::next_text_reader(Time now) {
  if (text_readers_.empty() || find(text_sink()) != nullptr) return;
  const TextReader next = text_readers_.front();
  text_readers_.erase(text_readers_.begin());
  registrations_.add(now, *clients_.find(next.client), text_sink(), next.handle);
}

void Router::withdraw_all(Time now, Client& client) {
  stop_sharing(client.id);
  const Peer owner = client.peer();
  while (!client.mailboxes.empty()) {
    const Address address = registrations_.remove_last(client);
    withdrawn(now, address, owner);
  }
}

// The address is assigned to a link that waits for it, if any.
void Router::withdrawn(Time now, Address address, const Peer& owner) {
  happened(now, EventKind::kWithdrawn, address, owner, owner);
  learn_again(now, address);
}

void Router::record_end(Time now, const Client& client, CloseReason reason) {
  happened({.at = now,
            .kind = kind_of_end(client.info.port, reason),
            .reason = reason,
            .client = client.peer()});
}

void Router::happened(Time now, EventKind kind, Address address, const Peer& client,
                      const Peer& owner) {
  happened({.at = now, .kind = kind, .address = address, .client = client, .owner = owner});
}

void Router::happened(const Event& event) {
  count(event.kind);
  if (is_audited(event.kind)) (void)audit_.add(event);
  hooks_.event(events_.add(event));
}

Peer Router::peer(ClientId id) const {
  const Client* client = clients_.find(id);
  return client == nullptr ? Peer{} : client->peer();
}

// --- Other routers

Outcome Router::stop_loop(Time now, const Client* from, const Client& to, const Message& message) {
  if (now >= next_loop_event_) {
    next_loop_event_ = now + kLoopEventEvery;
    happened(now, EventKind::kLoop, message.header.dest, from == nullptr ? Peer{} : from->peer(),
             to.peer());
  }
  return Outcome::kHopLimit;
}

void Router::set_uplink(Time now, ClientId link) {
  if (routes_.uplink() == link) return;
  routes_.set_uplink(link);
  happened(now, EventKind::kUplinkChanged, Address(), peer(link));
}

// --- announcements of other routers

std::optional<Origin> Router::exported(Address address) const {
  if (address == settings_.address) return registrations_.here();
  const Table::Entry* entry = find(address);
  if (entry == nullptr || address == text_sink()) return std::nullopt;
  const Client& owner = *clients_.find(entry->owner);
  if (only_down(&owner)) return std::nullopt;
  return registrations_.origin(owner, *entry);
}

void Router::continue_table(std::uint32_t number, std::span<const Address> former) {
  std::vector<Address> changed;
  for (const Address address : former)
    if (!exported(address)) changed.push_back(address);
  for_each_exported([&](Address address, const Origin&) {
    if (!std::ranges::binary_search(former, address)) changed.push_back(address);
  });
  registrations_.exported_table().continue_at(number, changed);
}

bool Router::learn(Time now, ClientId link, Address address, const Origin& origin) {
  Client* from = clients_.find(link);
  if (from == nullptr || address == text_sink()) return false;
  const Origin& here = registrations_.here();
  if (origin.router == here.router || origin.hops >= kHopsMax) {
    // Either one of our own mailboxes came back, or another router's announcement is in a loop,
    // or another router uses our address.
    const bool loop = origin.router != here.router || origin.epoch == here.epoch;
    happened(now, loop ? EventKind::kLoop : EventKind::kDuplicateRouter, address, from->peer(),
             peer_router(*from, origin));
    return false;
  }
  const Table::Entry* entry = find(address);
  if (entry == nullptr && address != settings_.address) {
    registrations_.add(now, *from, address, origin);
    if (address == origin.router) missing_.found(address);
    happened(now, EventKind::kRegistered, address, peer_router(*from, origin));
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

// The address is already owned by another link or a local client.
void Router::duplicate(Time now, const Client& link, Address address, const Origin& origin) {
  const Table::Entry* entry = find(address);
  const Client* owner = entry == nullptr ? nullptr : clients_.find(entry->owner);
  if (owner != nullptr && owner->info.port == PortKind::kLink) {
    const Origin current = this->origin(*entry);
    if (current.same_router(origin)) {
      // Two routes to the same router: use the shorter one.
      if (origin.hops >= current.hops) return;
      registrations_.wait(address, {owner->id, current});
      Client& loser = *clients_.find(owner->id);
      registrations_.remove(loser, address);
      learn_again(now, address);
      return;
    }
    // The same router after a restart: the old announcement will be withdrawn soon.
    if (current.router == origin.router) return;
    happened(now, EventKind::kDuplicateAddress, address, peer_router(link, origin),
             peer_router(*owner, current));
    return;
  }
  happened(now, EventKind::kDuplicateAddress, address, peer_router(link, origin),
           owner == nullptr ? Peer{} : owner->peer());
}

// The address has become free: assign it to a link that waited for it.
void Router::learn_again(Time now, Address address) {
  if (address == text_sink()) next_text_reader(now);
  if (find(address) != nullptr) return;
  const auto next = registrations_.take_waiting(address);
  if (next) learn(now, next->link, address, next->origin);
}

void Router::forget(Time now, ClientId link, Address address) {
  Client* from = clients_.find(link);
  if (from == nullptr || registrations_.stop_waiting(address, link)) return;
  const Table::Entry* entry = find(address);
  if (entry == nullptr || entry->owner != link) return;
  const Peer owner = peer_router(*from, origin(*entry));
  registrations_.remove(*from, address);
  withdrawn(now, address, owner);
}

void Router::forget_all(Time now, ClientId link) {
  Client* from = clients_.find(link);
  if (from == nullptr) return;
  registrations_.stop_waiting(link);
  withdraw_all(now, *from);
}

// Sorted by distance. A router announces its own address in the same way as its mailboxes.
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

// The link is down: the routers that no other link announces are now missing.
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

// The owner of a mailbox behind a link: the name of the link and the router that has the mailbox.
Peer Router::peer_router(const Client& link, const Origin& origin) const {
  Peer party = link.peer();
  party.endpoint = Text<56>(origin.router.to_string(settings_.widths));
  return party;
}

void Router::on_undelivered(Time now, ClientId link, const Header& header, Outcome outcome) {
  const Count one{1, header.length};
  messages_.add(PortKind::kLink, settings_.classes.of(header), outcome, one);
  drops_.add(now);
  count_dropped(clients_.find(link), one);
  if (header.type <= 0) return;
  // The sender is answered as if the message had been refused immediately.
  const NextHop back = routes_.next_hop(nullptr, header.src);
  if (back.to == nullptr) return;
  answer_not_available(now, receiver_of(*back.to, back.handle), header);
}

// --- the original's commands (legacy.h) and its watchdog

Outcome Router::carry_out(Time now, Client& sender, Message& message) {
  using Verb = LegacyCommand::Verb;
  const LegacyCommand command = parse_command(message);
  switch (command.verb) {
    case Verb::kRegister: {
      const bool success = carry_out_registration(now, sender, command);
      if (command.wants_reply) answer_command(now, sender, message.header, success);
      break;
    }
    case Verb::kDelete: {
      const Removal result = remove_mailbox(now, sender.id, command.mailbox);
      // In the original, deleting an unknown address succeeds.
      const bool success = result != Removal::kNotOwner;
      if (command.wants_reply) answer_command(now, sender, message.header, success);
      break;
    }
    case Verb::kPurge:
      withdraw_all(now, sender);
      break;
    case Verb::kAlive:
      sender.owes_answer = false;
      break;
    case Verb::kEnableWatchdog:
      lifesigns_.watch(now, sender);
      break;
    case Verb::kDisableWatchdog:
      lifesigns_.unwatch(sender);
      break;
    case Verb::kLogin:
      send_widths(now, sender, message);
      break;
    case Verb::kAdmin:
      if (const auto stopped = judge(now, sender, 0, message)) return *stopped;
      hooks_.admin(now, sender.id, message);
      break;
    case Verb::kMalformed:
      return Outcome::kMalformedCommand;
    case Verb::kUnknown:
      return Outcome::kUnknownCommand;
  }
  return Outcome::kHandled;
}

// Returns false when the address is not available.
bool Router::carry_out_registration(Time now, Client& sender, const LegacyCommand& command) {
  const Registration result = register_mailbox(now, sender.id, command.mailbox);
  if (result.status != Registration::Status::kOk) return false;
  if (command.keeps_newest && !sender.keeps_newest) {
    sender.keeps_newest = true;
    const Receiver client = receiver_of(sender);
    port_of(client).keep_newest(client);
  }
  return true;
}

// The original let any client delete any mailbox. It had no local clients, so their mailboxes are
// excluded: other programs send to them directly, without the router. Mailboxes of other routers
// are also excluded because those routers would not be notified.
bool Router::may_delete(const Client& by, const Client& owner) const {
  if (by.id == owner.id) return true;
  return settings_.compat_delete && owner.info.port != PortKind::kLocal &&
         owner.info.port != PortKind::kLink;
}

void Router::answer_command(Time now, const Client& client, const Header& request, bool success) {
  const Receiver to = receiver_of(client);
  port_of(to).reply(now, to, wire::reply_to(request, success ? type::kOk : type::kError));
}

// Only for clients that left room for the widths in their login; the answer overwrites the
// question.
void Router::send_widths(Time now, Client& client, Message& login) {
  namespace command = wire::router_command;
  if (settings_.widths == AddressWidths() || login.body().size() != command::kWidthsSize) return;
  std::ranges::copy(command::encode_widths(settings_.widths),
                    login.bytes.subspan(kHeaderSize).begin());
  login.header = wire::reply_to(login.header, command::kAddressWidths, command::kWidthsSize);
  (void)hand_over(now, receiver_of(client), client, login);
}

void Router::on_progress(ClientId id) {
  if (Client* client = clients_.find(id)) client->owes_answer = false;
}

void Router::on_timeout(Time now) {
  if (policy() != nullptr && now >= policy()->next_report()) report_denials(now);
  if (now >= leases_.next_end()) ended(now, leases_.end_old(now));
  const Lifesigns::Beat beat = lifesigns_.beat(now);
  if (beat == Lifesigns::Beat::kNotYet) return;
  clients_.for_each([&](Client& client) {
    if (!client.watched) return;
    if (client.owes_answer && beat == Lifesigns::Beat::kAsk) {
      give_up(now, client, CloseReason::kWatchdog);
    } else {
      client.owes_answer = true;
      ask_for_lifesign(now, client);
    }
  });
}

void Router::ask_for_lifesign(Time now, const Client& client) {
  count(EventKind::kLifesign);
  const Receiver to = receiver_of(client);
  port_of(to).reply(now, to, {.type = wire::router_command::kLifesign});
}

void Router::give_up(Time now, Client& client, CloseReason reason) {
  const Receiver connection = receiver_of(client);
  disconnect(now, client.id, reason);
  port_of(connection).close(connection, reason);
}

}  // namespace tims::core

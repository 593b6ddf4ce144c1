#include "router/link/advertiser.h"

namespace tims::link {
namespace {

// Minimum interval between two requests for a whole table.
constexpr Duration kAskEvery = std::chrono::milliseconds(500);
// After this time without a message about a table that differs from ours, one was lost.
constexpr Duration kStalledAfter = std::chrono::seconds(1);
// Minimum interval between two requests for the rest of a table that was too large.
constexpr Duration kAskForRestEvery = std::chrono::seconds(10);
// Minimum interval between two log entries about a router that announces too much.
constexpr Duration kNoteEvery = std::chrono::seconds(10);
// So many wrong answers in a row occur only when the lane is damaged in spite of UDP's checksum.
constexpr int kAskedInVainMax = 8;
// While this much is still to be sent, no more is announced, so that changes are combined.
constexpr std::uint64_t kBacklogMax = 64 << 10;

// Hops: more than any other route in a tree, and well below kHopsMax.
constexpr std::uint8_t kFarther = 6;

// Hops as counted by the other router: one less than here.
core::Origin as_announced(core::Origin origin) {
  --origin.hops;
  return origin;
}

}  // namespace

void Advertiser::begin(Time now, core::ClientId client, bool imports) {
  client_ = client;
  imports_ = imports;
  if (imports_) request(now, holding_);
}

// What is not in the other side's current state is asked for again.
void Advertiser::save(StateWriter& to, std::uint32_t table_number) const {
  const bool all_known = advertised_.number == table_number;
  to.put(wanted_, scope_);
  to.put(all_known ? advertised_.number : 0, all_known ? advertised_.hash : 0);
  const core::Client* client = router_.client(client_);
  const bool knows_all =
      imports_ && client != nullptr && !incomplete_ && !router_.has_waiting(client_);
  to.put(knows_all ? holding_.number : 0, knows_all ? holding_.hash : 0);
  const auto put = [&](std::uint32_t address, const core::Origin& origin) {
    to.put(address, origin.router.raw(), origin.epoch, origin.hops);
  };
  if (!knows_all) return to.put(std::uint32_t{0});
  to.put(static_cast<std::uint32_t>(client->mailboxes.size() + refused_.size()));
  for (const core::OwnedMailbox& mailbox : client->mailboxes)
    put(mailbox.address.raw(), *held(mailbox.address));
  for (const auto& [address, origin] : refused_) put(address, origin);
}

bool Advertiser::restore(Time now, core::ClientId client, bool imports, StateReader& from) {
  client_ = client;
  imports_ = imports;
  wanted_ = from.get<std::uint8_t>() != 0;
  if (!get_enum(from, Scope::kAll, scope_)) return false;
  from.get(advertised_.number, advertised_.hash, holding_.number, holding_.hash);
  for (auto count = from.get<std::uint32_t>(); count > 0 && from.ok(); --count) {
    const Address address(from.get<std::uint32_t>());
    core::Origin origin{.router = Address(from.get<std::uint32_t>())};
    from.get(origin.epoch, origin.hops);
    if (from.ok() && imports_) add(now, address, origin);
  }
  if (!imports_) return from.ok();
  if (holding_.hash != hash_ || holding_.number == 0) request(now, {});
  return from.ok();
}

void Advertiser::end() {
  wanted_ = false;
  advertised_ = holding_ = {};
  hash_ = 0;
  held_count_ = 0;
  refused_.clear();
  incomplete_ = false;
  asked_in_vain_ = 0;
  client_ = core::kNoClient;
}

void Advertiser::send(Time now, ControlMessage& message) {
  session_.send_control(now, message.finish());
}

void Advertiser::request(Time now, const TableState& state) {
  asked_ = now;
  ControlMessage message(control::kWant);
  message.put(state);
  send(now, message);
}

// --- our announcements

void Advertiser::set_scope(Time now, Scope scope) {
  if (scope_ == scope) return;
  scope_ = scope;
  if (wanted_) advertise_all(now);
}

void Advertiser::advertise(Time now) {
  if (!wanted_ || scope_ == Scope::kNothing || session_.queued_bytes(kControlLane) > kBacklogMax)
    return;
  const core::ExportedTable& below = router_.exported_table();
  if (advertised_.number == below.number()) return;
  scope_ == Scope::kAll&& below.remembers(advertised_.number) ? advertise_changes(now)
                                                              : advertise_all(now);
}

void Advertiser::advertise_all(Time now) {
  // Addresses that become farther are announced again without removing them first, so they stay
  // known.
  if (scope_ != Scope::kAsFarther) {
    ControlMessage begin(control::kSnapshot);
    send(now, begin);
  }
  advertised_ = {};
  if (scope_ != Scope::kNothing) advertise_table(now);
  done(now);
}

void Advertiser::advertise_table(Time now) {
  ControlMessage message(control::kAdd);
  advertised_.number = router_.exported_table().number();
  router_.for_each_exported([&](Address address, core::Origin origin) {
    if (scope_ == Scope::kAsFarther) origin.hops += kFarther;
    advertised_.hash ^= core::table_hash(address, origin);
    message.put(address, origin);
    if (!message.full()) return;
    send(now, message);
    message = ControlMessage(control::kAdd);
  });
  if (!message.empty()) send(now, message);
}

// Each changed address is announced in its current state, so an address that came and went is not
// announced.
void Advertiser::advertise_changes(Time now) {
  ControlMessage gone(control::kRemove);
  ControlMessage there(control::kAdd);
  const core::ExportedTable& below = router_.exported_table();
  const auto flush = [&](ControlMessage& message, std::int8_t type, bool always) {
    const bool due = message.full() || (always && !message.empty());
    if (!due) return;
    send(now, message);
    message = ControlMessage(type);
  };
  for (std::uint32_t n = advertised_.number + 1; n != below.number() + 1; ++n) {
    const Address address = below.changed(n);
    if (const auto origin = router_.exported(address)) {
      there.put(address, *origin);
    } else {
      gone.put(address);
    }
    flush(gone, control::kRemove, false);
    flush(there, control::kAdd, false);
  }
  flush(gone, control::kRemove, true);
  flush(there, control::kAdd, true);
  advertised_ = {below.number(), below.hash()};
  done(now);
}

void Advertiser::done(Time now) {
  ControlMessage message(control::kDone);
  message.put(advertised_);
  send(now, message);
}

// --- the other side's table

std::optional<core::Origin> Advertiser::held(Address address) const {
  const auto refused = refused_.find(address.raw());
  if (refused != refused_.end()) return refused->second;
  const auto announced = router_.announced(client_, address);
  return announced ? std::optional(as_announced(*announced)) : std::nullopt;
}

void Advertiser::add(Time now, Address address, core::Origin origin) {
  if (const auto old = held(address)) {
    if (*old == origin) return;
    remove(now, address);
  }
  if (held_count_ >= mailboxes_max_) return leave_out(now, address);
  hash_ ^= core::table_hash(address, origin);
  ++held_count_;
  core::Origin here = origin;
  if (here.hops < core::kHopsMax) ++here.hops;
  const bool countable = here.hops == origin.hops + 1;
  const core::Client* from = router_.client(client_);
  const bool allowed = from != nullptr && router_.routes().may_come_from(*from, address);
  if (!allowed) note(now, core::EventKind::kAddressRefused, address);
  if (!allowed || !router_.learn(now, client_, address, here) || !countable) {
    router_.forget(now, client_, address);
    refused_[address.raw()] = origin;
    ++refused_count_;
  }
}

void Advertiser::leave_out(Time now, Address address) {
  incomplete_ = true;
  ++refused_count_;
  note(now, core::EventKind::kMailboxLimit, address);
}

void Advertiser::note(Time now, core::EventKind kind, Address address) {
  if (now < next_note_) return;
  next_note_ = now + kNoteEvery;
  const core::Client* from = router_.client(client_);
  if (from != nullptr)
    router_.note({.at = now, .kind = kind, .address = address, .client = from->peer()});
}

void Advertiser::remove(Time now, Address address) {
  const auto old = held(address);
  if (!old) return;
  hash_ ^= core::table_hash(address, *old);
  --held_count_;
  if (refused_.erase(address.raw()) == 0) router_.forget(now, client_, address);
}

void Advertiser::forget_all(Time now) {
  router_.forget_all(now, client_);
  refused_.clear();
  incomplete_ = false;
  hash_ = 0;
  held_count_ = 0;
}

bool Advertiser::on_control(Time now, const core::Message& message) {
  TableState state;
  // Larger messages are invalid: the cost of one message is bounded.
  if (message.bytes.size() > kHeaderSize + ControlMessage::kBodyMax) return false;
  if (message.header.type != control::kWant) last_message_ = now;
  switch (message.header.type) {
    case control::kWant:
      if (!read_state(message.body(), state)) return false;
      wanted_ = true;
      // Requested again before the last answer was sent: a later keep-alive repeats the request.
      if (session_.queued_bytes(kControlLane) > kBacklogMax) return true;
      if (scope_ == Scope::kAll &&
          state == TableState{router_.exported_table().number(), router_.exported_table().hash()} &&
          state.number != 0) {
        advertised_ = state;
        done(now);
      } else {
        advertise_all(now);
      }
      return true;
    case control::kSnapshot:
      if (imports_) forget_all(now);
      return true;
    case control::kAdd:
      return read_announcements(message.body(), [&](Address address, const core::Origin& origin) {
        if (imports_) add(now, address, origin);
      });
    case control::kRemove:
      return read_addresses(message.body(), [&](Address address) {
        if (imports_) remove(now, address);
      });
    case control::kDone:
      if (!read_state(message.body(), holding_)) return false;
      if (holding_.hash == hash_) asked_in_vain_ = 0;
      if (imports_ && !incomplete_ && holding_.hash != hash_ && now >= asked_ + kAskEvery)
        request(now, {});
      return true;
    default:
      return false;
  }
}

std::optional<TableState> Advertiser::to_ask_for(Time now, const TableState& theirs) const {
  if (!imports_ || now < asked_ + kAskEvery) return std::nullopt;
  if (theirs == kNotRequested) return TableState{};
  if (incomplete_) {
    const bool room = held_count_ < mailboxes_max_ && now >= asked_ + kAskForRestEvery;
    return room ? std::optional(TableState{}) : std::nullopt;
  }
  if (theirs.number == holding_.number) {
    if (theirs.hash == hash_) return std::nullopt;
    return TableState{};
  }
  const bool stalled = now >= last_message_ + kStalledAfter && now >= asked_ + kStalledAfter;
  if (!stalled) return std::nullopt;
  return holding_.hash == hash_ ? holding_ : TableState{};
}

bool Advertiser::compare(Time now, const TableState& theirs) {
  const auto state = to_ask_for(now, theirs);
  if (!state) return true;
  const bool has_arrived = session_.newest_acked_sent() >= asked_;
  request(now, *state);
  return incomplete_ || !has_arrived || ++asked_in_vain_ <= kAskedInVainMax;
}

}  // namespace tims::link

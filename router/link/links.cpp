#include "router/link/links.h"

#include <algorithm>
#include <utility>

#include "router/core/random.h"
#include "wire/header.h"

namespace tims::link {
namespace {

using namespace std::chrono_literals;

// Maximum for one link before the others have their turn.
constexpr std::size_t kBurstsPerTurn = 16;
// Differentiated services (RFC 4594): EF for urgent classes, AF41 and AF31 below, CS1 for texts.
// AF21 and AF11 are not used: Linux before 6.8 sends those on Wi-Fi as background, like CS1.
constexpr std::array<std::uint8_t, kLanes> kDscp{8, 0, 0, 26, 34, 46, 46, 46, 48};

// How long a more preferred super router must have been up before it is used again.
constexpr Duration kFailBackAfter = std::chrono::milliseconds(500);
// How long the previous super router still knows what is below us, so that messages in transit
// arrive.
constexpr Duration kOverlap = std::chrono::seconds(1);
// While this much waits in the control lane, no part of a list is added.
constexpr std::uint64_t kListBacklogMax = 64 << 10;

// News of the fleet come from whoever announces himself; looking at them takes time for each link
// and router.
constexpr Duration kLookEvery = std::chrono::milliseconds(10);
constexpr Duration kDoubleReportEvery = std::chrono::seconds(1);

}  // namespace

Links::Links(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
             const LinksSetup& setup, LinksShell* shell)
    : router_(router),
      pool_(pool),
      memory_(memory),
      setup_(setup),
      shell_(shell),
      packing_(setup.self.widths, setup.self.classes, setup.clock),
      reception_(router, *this,
                 {.self = setup.self,
                  .secret = setup.secret,
                  .handshaker = setup.handshaker,
                  .links_max = setup.links_max}),
      lists_(*this),
      fleet_(setup.self),
      scratch_(std::make_unique<std::byte[]>(kBurstBytesMax + kDatagramMax)) {}

// SipHash in counter mode: one number reveals nothing about the others.
std::uint64_t Links::random() { return core::sip_hash(setup_.secret, {++drawn_}); }

// --- configuration

void Links::configure(Time now, std::span<const LinkSettings> wanted) {
  settings_.clear();
  for (const LinkSettings& settings : wanted) settings_.push_back(own_settings(settings));
  supers_.clear();
  const auto find_wanted = [&](const Link& link) {
    return std::ranges::find_if(settings_, [&](const LinkSettings& s) {
      return s.kind == link.settings().kind && s.connects == link.settings().connects &&
             s.to == link.settings().to && s.system == link.settings().system;
    });
  };
  for (std::uint32_t slot = 0; slot < slots_.size(); ++slot) {
    if (!slots_[slot].link) continue;
    const auto same = find_wanted(*slots_[slot].link);
    if (same == settings_.end()) {
      remove(now, slot);
    } else {
      slots_[slot].link->configure(now, *same);
    }
  }
  for (const LinkSettings& settings : settings_) {
    if (!settings.connects) continue;
    const Link* there = first_link([&](const Link& link) {
      return link.settings().connects && link.settings().to == settings.to;
    });
    const Link& link = there == nullptr ? add(now, settings) : *there;
    if (settings.kind == LinkKind::kSuper) supers_.push_back(link.slot());
  }
  choose_ = true;
  look_for_all(now);
}

LinkSettings Links::own_settings(LinkSettings settings) const {
  settings.session.message_max = setup_.self.message_max;
  // One of the largest messages fits while the last bytes of another are being acknowledged.
  settings.session.queue_bytes_max = std::max<std::uint64_t>(
      settings.session.queue_bytes_max, 2 * record_size(setup_.self.message_max));
  settings.session.classes = setup_.self.classes;
  settings.secure = settings.secure && reception_.has_keys();
  return settings;
}

Link& Links::add(Time now, const LinkSettings& settings) {
  std::uint32_t slot = 0;
  while (slot < slots_.size() && slots_[slot].link) ++slot;
  if (slot == slots_.size()) slots_.emplace_back();
  LinkContext& context = *this;
  slots_[slot].link =
      std::make_unique<Link>(router_, pool_, memory_, done_, context, slot, settings, now);
  return *slots_[slot].link;
}

void Links::remove(Time now, std::uint32_t slot) {
  Slot& its = slots_[slot];
  its.link->take_down(now);
  report_losses(now);
  forget_names(slot);
  std::erase(touched_, its.link.get());
  if (uplink_ == its.link.get()) uplink_ = nullptr;
  std::erase(supers_, slot);
  its = {.wakes_at = its.wakes_at};
  choose_ = true;
}

void Links::set_targets(Time now, const std::string& to, PathKind kind,
                        std::span<const NetAddress> targets) {
  for_each_link([&](Link& link) {
    if (!link.settings().connects || link.settings().to != to) return;
    link.set_targets(now, kind, targets);
    touch(link);
  });
}

void Links::note_unreachable(const std::string& to, std::string_view why) {
  for_each_link([&](Link& link) {
    if (link.settings().connects && link.settings().to == to) link.note_no_candidate(why);
  });
}

void Links::network_changed(Time now) {
  for_each_link([&](Link& link) {
    link.call_now(now);
    touch(link);
  });
}

void Links::renew_keys(Time now) {
  for_each_link([&](Link& link) {
    link.renew_keys(now);
    touch(link);
  });
}

// --- lists of the fleet

void Links::use_list(Time now, FleetListBytes list, StandingOf standing_of) {
  standing_of_ = std::move(standing_of);
  for_each_link([&](Link& link) {
    if (!link.keys().are_used()) return;
    link.judge(now, standing(link.certificate()));
    index(link);
    touch(link);
  });
  lists_.set_own(now, std::move(list));
}

void Links::begin_lists(Time now, const Link& link) {
  if (setup_.lists != nullptr)
    lists_.begin(now, link.slot(), link.settings().kind == LinkKind::kSuper);
}

void Links::send_list_message(Time now, std::uint32_t slot, ControlMessage& message) {
  Link& link = *slots_[slot].link;
  link.send_control(now, message);
  touch(link);
}

// What the link carries in ten milliseconds: so long may an urgent message wait for it.
std::size_t Links::list_part_size(std::uint32_t slot) const {
  const LinkSession& session = slots_[slot].link->session();
  if (session.queued_bytes(kControlLane) > kListBacklogMax) return 0;
  return static_cast<std::size_t>(std::clamp<std::uint64_t>(
      session.rate() / 100, ListExchange::kPartMin, ListExchange::kPartMax));
}

void Links::check_list(std::uint64_t transfer, std::uint64_t number, std::uint32_t slot,
                       std::vector<std::byte>&& bytes) {
  setup_.lists->check(transfer, number, slots_[slot].link->peer().name.view(), std::move(bytes));
}

std::vector<std::string> Links::names_to_resolve() const {
  std::vector<std::string> names;
  for_each([&](const Link& link) {
    if (link.settings().connects && (!link.is_up() || !link.paths().has_targets()))
      names.push_back(link.settings().to);
  });
  return names;
}

// --- input

Link* Links::by_token(std::uint64_t token) {
  const auto found = ours_.find(token);
  if (found == ours_.end()) return nullptr;
  Link* link = slots_[found->second].link.get();
  return link->our_token() == token ? link : nullptr;
}

void Links::touch(Link& link) {
  if (slots_[link.slot()].is_touched) return;
  slots_[link.slot()].is_touched = true;
  touched_.push_back(&link);
}

void Links::on_datagram(Time now, const NetAddress& from, std::span<std::byte> bytes) {
  if (ends_ || holds_back()) return;
  if (const auto data = decode_data(bytes)) return on_data(now, from, *data);
  const auto datagram = decode(bytes);
  if (!datagram) {
    ++strange_;
    return;
  }
  if (const auto* hello = std::get_if<Hello>(&*datagram))
    return reception_.on_hello(now, from, *hello);
  if (const auto* hello = std::get_if<SealedHello>(&*datagram))
    return reception_.on_hello(now, from, *hello);
  if (const auto* crypto = std::get_if<Crypto>(&*datagram))
    return reception_.on_crypto(now, from, *crypto);
  if (const auto* retry = std::get_if<Retry>(&*datagram)) {
    Link* link = by_token(retry->echo);
    if (link == nullptr) return;
    link->on_retry(now, from, *retry);
    return touch(*link);
  }
  if (const auto* welcome = std::get_if<Welcome>(&*datagram))
    return on_welcome(now, from, *welcome, nullptr);
  if (const auto* refuse = std::get_if<Refuse>(&*datagram)) return on_refuse(now, from, *refuse);
  on_reset(now, from, std::get<Reset>(*datagram));
}

// Only a receiver of our datagrams can know the token in them.
void Links::on_reset(Time now, const NetAddress& from, const Reset& reset) {
  const auto found = theirs_.find(reset.token);
  if (found == theirs_.end()) return;
  Link& link = *slots_[found->second].link;
  // Challenges also go to possible addresses of the other router, where other routers do not know
  // us.
  if (link.their_token() != reset.token || link.paths().is_strange(from)) return;
  link.on_reset(now, from);
  touch(link);
}

void Links::on_data(Time now, const NetAddress& from, const Data& data) {
  const std::uint64_t token = data.header.token;
  if (Link* link = by_token(token)) {
    link->on_data(now, from, data);
    return touch(*link);
  }
  ++unknown_token_;
  if (!resets_.try_take(now)) return;
  std::array<std::byte, kControlDatagramMax> bytes{};
  send(from, std::span(bytes).first(encode(Reset{token}, bytes)));
}

void Links::on_welcome(Time now, const NetAddress& from, const Welcome& welcome,
                       Handshakes::One* handshake) {
  Link* link = by_token(welcome.echo);
  const bool sealed = handshake != nullptr;
  if (link == nullptr || link->settings().secure != sealed || (link->is_up() && !sealed)) return;
  const auto refuse_welcome = [&](const std::string& text) {
    link->on_refuse(now, from, {.echo = welcome.echo, .text = std::string_view(text)});
    touch(*link);
  };
  if (welcome.version != (sealed ? kVersionSealed : kVersionPlain))
    return refuse_welcome("it supports version " + std::to_string(welcome.version) +
                          " of the protocol");
  if (welcome.identity.widths != setup_.self.widths)
    return refuse_welcome("the widths of its address fields differ: see [address] widths");
  if (welcome.identity.classes != setup_.self.classes)
    return refuse_welcome("its message.classes are " + welcome.identity.classes.to_string() +
                          ", here " + setup_.self.classes.to_string());
  if (sealed && !is_named(welcome.identity, handshake->verified.peer))
    return refuse_welcome(name_mismatch(welcome.identity, handshake->verified.peer));
  if (link->settings().kind == LinkKind::kSuper && !is_above(welcome.identity, setup_.self))
    return refuse_welcome("it is a " + std::string(name(welcome.identity.role)) +
                          " router, which cannot be above this one");
  const Link* other = link_to(welcome.identity);
  if (other != nullptr && other != link && other->is_up())
    return refuse_welcome("there is already a link to " +
                          std::string(welcome.identity.name.view()) + ", at " +
                          other->address().to_string());
  link->on_welcome(now, from, welcome, sealed ? std::move(handshake->verified) : Verified{});
  index(*link);
  touch(*link);
}

// --- deliveries from the router

core::Outcome Links::deliver(Time now, const core::Receiver& to, const core::Message& message) {
  Link& link = *slots_[to.token].link;
  touch(link);
  return link.send(now, message);
}

void Links::reply(Time now, const core::Receiver& to, const Header& header) {
  std::array<std::byte, kHeaderSize> bytes{};
  wire::encode_header(header, bytes);
  const core::Outcome outcome = deliver(now, to, {.header = header, .bytes = bytes});
  if (!core::taken(outcome)) lost(slots_[to.token].link->client(), header, outcome);
}

// A value that this router keeps is decompressed here in any case.
bool Links::goes_on_packed(core::ClientId from, const core::Message& message,
                           std::uint32_t size) const {
  const core::NewestValues* newest = router_.newest();
  if (newest != nullptr && newest->wants(message.header)) return false;
  const auto next = router_.routes().next_hop(router_.client(from), message.header.dest);
  if (next.to == nullptr || next.to->info.port != core::PortKind::kLink) return false;
  const Link* link = this->link(next.to->info.token);
  return link != nullptr && link->takes_packed(message, size);
}

bool Links::take_packed(core::ClientId link, core::Message& message, PackingCounters& counters) {
  const auto size = packing_.unpacked_size(message);
  if (!size) {
    ++counters.broken;
    return false;
  }
  if (goes_on_packed(link, message, *size)) {
    ++counters.passed;
    return true;
  }
  const auto room =
      *size <= setup_.self.message_max ? unpacked_.take(*size) : std::span<std::byte>();
  if (room.empty()) {
    lost(link, message.header, core::Outcome::kIncomplete);
    return false;
  }
  return packing_.unpack(message, room, counters);
}

bool Links::has_room_to_unpack() {
  return unpacked_.reserve(
      std::min<std::size_t>(kHeaderSize + compression::kBlockMax, setup_.self.message_max));
}

std::uint64_t Links::queued_bytes(std::uint32_t token) const {
  const Link* link = this->link(token);
  return link == nullptr ? 0 : link->session().queued_bytes();
}

// --- time

void Links::on_timeout(Time now) {
  look_who_is_back(now);
  if (holds_back()) return;
  if (look_due_ <= now) look_for_all_soon(now);
  while (!wake_.empty() && wake_.top().at <= now) {
    const Wake wake = wake_.top();
    wake_.pop();
    if (slots_[wake.slot].wakes_at == wake.at) slots_[wake.slot].wakes_at = kNever;
    Link* link = slots_[wake.slot].link.get();
    if (link == nullptr) continue;
    if (link->settings().is_automatic() && link->should_try_next()) {
      ++slots_[wake.slot].tries;
      look_for(now, *link);
    }
    if (slots_[wake.slot].standby.at <= now) look_for(now, *link);
    link->on_timeout(now);
    link->is_gone(now) ? remove(now, wake.slot) : touch(*link);
  }
  reception_.on_timeout(now);
  lists_.on_timeout(now);
  // A super router may have been up long enough.
  if (supers_.size() > 1) choose_ = true;
}

// Called after every change of the tokens or of the other router.
void Links::index(const Link& link) {
  const std::uint32_t slot = link.slot();
  Names names{.ours = link.our_token(), .theirs = link.their_token()};
  if (link.peer().epoch != 0) names.peer = link.peer().address().raw();
  if (names == slots_[slot].names) return;
  forget_names(slot);
  slots_[slot].names = names;
  if (names.ours != 0) ours_[names.ours] = slot;
  if (names.theirs != 0) theirs_[names.theirs] = slot;
  if (names.peer) peers_[*names.peer] = slot;
}

void Links::forget_names(std::uint32_t slot) {
  const Names names = std::exchange(slots_[slot].names, {});
  const auto forget = [slot](auto& index, auto name) {
    const auto found = index.find(name);
    if (found != index.end() && found->second == slot) index.erase(found);
  };
  forget(ours_, names.ours);
  forget(theirs_, names.theirs);
  if (names.peer) forget(peers_, *names.peer);
}

// --- announcements

void Links::advertise(Time now) {
  // Nothing to do while the table has not changed; routers below never receive it.
  const std::uint32_t number = router_.exported_table().number();
  const bool changed = std::exchange(advertised_, number) != number;
  const auto advertise_one = [&](Link& link) {
    if (!link.is_up() || link.settings().kind == LinkKind::kSub) return;
    link.advertise(now);
    if (changed) touch(link);
  };
  if (changed) return for_each_link(advertise_one);
  for (Link* link : touched_) advertise_one(*link);
}

void Links::lost(core::ClientId client, const Header& header, core::Outcome why) {
  losses_.push_back({client, header, why});
}

void Links::report_losses(Time now) {
  // NOLINTNEXTLINE(modernize-loop-convert): answers may add to them
  for (std::size_t i = 0; i < losses_.size(); ++i) {
    const Lost lost = losses_[i];
    router_.on_undelivered(now, lost.client, lost.header, lost.why);
  }
  losses_.clear();
}

// --- output

void Links::send(const NetAddress& to, std::span<const std::byte> datagram) {
  if (datagram.empty() || !to || singles_.size() >= 4096) return;
  Single& single = singles_.emplace_back();
  single.to = to;
  single.size = static_cast<std::uint32_t>(datagram.size());
  std::ranges::copy(datagram, single.bytes.begin());
}

// Without a sender, datagrams are lost, as they could be on the network.
bool Links::offer(const Burst& burst) {
  DatagramSender* sender = senders_[index(burst.to.kind)];
  return sender == nullptr || sender->offer(burst);
}

bool Links::send_bursts(Time now, Link& link) {
  for (std::size_t n = 0; n < kBurstsPerTurn; ++n) {
    Burst burst{.to = link.address()};
    std::size_t size = 0;
    std::size_t count = 0;
    const std::span all(scratch_.get(), kBurstBytesMax + kDatagramMax);
    for (;;) {
      const std::size_t room = count == 0 ? kDatagramMax : burst.datagram_size;
      const std::size_t one = link.build(now, all.subspan(size, room));
      if (one == 0) break;
      if (count == 0) {
        burst.datagram_size = one;
        burst.dscp = kDscp[link.session().last_lane()];
      }
      size += one;
      ++count;
      // All datagrams of a burst have the same size except the last. A shorter one ends the
      // burst, or belongs to a new one.
      const bool full = one == link.session().datagram_size() && one == burst.datagram_size;
      if (!full || count == kBurstDatagramsMax || size + one > kBurstBytesMax) break;
    }
    if (count == 0) return true;
    burst.bytes = all.first(size);
    if (!offer(burst)) {
      held_ = burst;
      return false;
    }
  }
  return false;
}

void Links::flush(Time now) {
  look_who_is_back(now);
  if (holds_back()) return;
  if (std::ranges::all_of(senders_, [](const auto* sender) { return sender == nullptr; })) return;
  choose_uplink(now);
  advertise(now);
  report_losses(now);
  if (held_.to && !offer(held_)) {
    if (shell_ != nullptr) shell_->wait_for_sender();
    return;
  }
  held_ = {};
  for (const Single& single : singles_) {
    // A datagram that the socket does not accept is lost, as it could be on the network.
    (void)offer({.to = single.to,
                 .bytes = std::span(single.bytes).first(single.size),
                 .datagram_size = single.size,
                 .dscp = kDscp[kControlLane]});
  }
  singles_.clear();
  std::erase_if(touched_, [&](Link* link) { return !held_.to && flush_link(now, *link); });
  if (shell_ == nullptr) return;
  if (held_.to) {
    shell_->wait_for_sender();
  } else if (!touched_.empty()) {
    shell_->continue_later();
  }
}

// Returns false when it has more to send.
bool Links::flush_link(Time now, Link& link) {
  if (!send_bursts(now, link)) return false;
  std::span probe(scratch_.get(), kDatagramMax);
  const std::size_t size = link.build_probe(now, probe);
  if (size > 0)
    (void)offer({.to = link.address(), .bytes = probe.first(size), .datagram_size = size});
  if (slots_[link.slot()].was_up != link.is_up()) look_again(now, link);
  slots_[link.slot()].is_touched = false;
  index(link);
  const Time at = std::min(slots_[link.slot()].standby.at, link.next_timeout(now));
  if (at < slots_[link.slot()].wakes_at) {
    slots_[link.slot()].wakes_at = at;
    wake_.push({at, link.slot()});
  }
  return true;
}

void Links::end(Time now) {
  ends_ = true;
  former_.reset();
  for_each_link(
      [&](Link& link) { link.take_down(now, Link::State::kDown, core::CloseReason::kShutdown); });
}

// --- for the next router

void Links::announce_pause(Time now) {
  for_each_link([&](Link& link) { link.announce_pause(now); });
}

// One that is restarted again before its programs are back has told the others nothing: for them,
// its table is still that of the former router, and the next one waits for the same programs.
std::vector<std::byte> Links::save(Time now) const {
  Handover left{.at = now, .self = setup_.self};
  if (former_) {
    left = {.at = now,
            .table_number = former_->table_number,
            .self = setup_.self,
            .exported = former_->exported,
            .mailboxes = former_->mailboxes};
  } else {
    left.table_number = router_.exported_table().number();
    router_.for_each_exported(
        [&](Address address, const core::Origin&) { left.exported.push_back(address); });
    std::ranges::sort(left.exported);
  }
  router_.table().for_each([&](const core::Table::Entry& entry) {
    const core::Client* owner = router_.client(entry.owner);
    if (owner != nullptr && owner->info.port == core::PortKind::kLocal)
      left.mailboxes.push_back(entry.address);
  });
  StateWriter links;
  for_each([&](const Link& link) {
    StateWriter state;
    if (!link.save(state, left.table_number)) return;
    const LinkSettings& settings = link.settings();
    links.put(settings.kind, settings.connects, settings.system.has_value(),
              settings.system.value_or(0));
    links.put_text(settings.to);
    links.put_bytes(state.bytes());
  });
  left.links = std::move(links.bytes());
  return left.encode();
}

std::size_t Links::restore(Time now, Handover former) {
  former_ = std::move(former);
  back_until_ = now + kReturnTime;
  singles_.clear();
  std::size_t restored = 0;
  for (StateReader in(now, former_->links); !in.empty();)
    restored += restore_link(now, in) ? 1U : 0U;
  former_->links = {};
  choose_ = true;
  choose_uplink(now);
  report_losses(now);
  return restored;
}

// Links that are not configured any more end.
bool Links::restore_link(Time now, StateReader& from) {
  LinkSettings like;
  const bool known = get_enum(from, LinkKind::kSub, like.kind);
  like.connects = from.get<std::uint8_t>() != 0;
  const bool only_one = from.get<std::uint8_t>() != 0;
  const auto system = from.get<std::uint16_t>();
  if (only_one) like.system = system;
  like.to = from.text();
  StateReader state(now, from.bytes());
  const auto settings = std::ranges::find_if(settings_, [&](const LinkSettings& one) {
    return one.kind == like.kind && one.connects == like.connects && one.to == like.to &&
           one.system == like.system;
  });
  if (!known || !from.ok() || settings == settings_.end()) return false;
  if (!like.connects && links_in_use() >= setup_.links_max) return false;
  Link* there = !like.connects ? &add(now, *settings) : first_link([&](const Link& link) {
    return link.settings().connects && link.settings().to == like.to && link.their_token() == 0;
  });
  if (there == nullptr) return false;
  const bool restored = there->restore(now, state) && link_to(there->peer()) == nullptr;
  // It may have been revoked meanwhile.
  if (restored && there->settings().secure) there->judge(now, standing(there->certificate()));
  index(*there);
  touch(*there);
  if (!restored) like.connects ? there->start_anew(now) : remove(now, there->slot());
  return restored;
}

void Links::look_who_is_back(Time now) {
  if (!former_) return;
  std::vector<Address>& awaited = former_->mailboxes;
  while (!awaited.empty() && router_.find(awaited.back()) != nullptr) awaited.pop_back();
  if (!awaited.empty() && now < back_until_) return;
  router_.continue_table(former_->table_number, former_->exported);
  former_.reset();
  for_each_link([&](Link& link) {
    link.go_on(now);
    touch(link);
  });
  if (shell_ != nullptr) shell_->receive_again();
}

// --- manual control

Link* Links::find(std::string_view name) {
  return first_link([&](const Link& link) {
    return link.peer().name.view() == name || link.settings().to == name ||
           link.address().to_string() == name;
  });
}

bool Links::act(Time now, std::string_view name, Action what) {
  Link* link = find(name);
  if (link == nullptr) return false;
  switch (what) {
    case Action::kUp:
      link->bring_up(now);
      break;
    case Action::kDown:
      link->take_down(now);
      break;
    case Action::kReset:
      link->start_anew(now);
      break;
  }
  touch(*link);
  return true;
}

// --- for the reception

Link* Links::link_to(const Identity& peer) {
  const auto found = peers_.find(peer.address().raw());
  if (found == peers_.end()) return nullptr;
  Link* link = slots_[found->second].link.get();
  return link->is_to(peer) ? link : nullptr;
}

bool Links::calls(const LinkSettings& settings, const NetAddress& from, const Identity& peer) {
  return first_link([&](const Link& link) {
           return link.settings().to == settings.to &&
                  (link.paths().is_target(from) || link.is_to(peer));
         }) != nullptr;
}

std::size_t Links::links_in_use() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(slots_, [](const Slot& slot) { return slot.link != nullptr; }));
}

void Links::was_taken(Link& link) {
  index(link);
  touch(link);
}

void Links::on_refuse(Time now, const NetAddress& from, const Refuse& refuse) {
  Link* link = by_token(refuse.echo);
  if (link == nullptr) return;
  link->on_refuse(now, from, refuse);
  touch(*link);
}

// --- routers of the fleet

void Links::on_announced(Time now, const Announcement& announcement) {
  if (!fleet_.add(announcement)) return;
  const Identity& identity = announcement.identity;
  if (fleet_.is_double(identity) && now >= double_reported_ + kDoubleReportEvery) {
    double_reported_ = now;
    router_.note({.at = now,
                  .kind = core::EventKind::kDuplicateRouter,
                  .address = identity.address(),
                  .client = link_peer(identity.name.view(), announcement.dds.to_string()),
                  .owner = link_peer(setup_.self.name.view(), "this router")});
  }
  look_for_all_soon(now);
}

void Links::on_gone(Time now, const NetAddress& dds) {
  fleet_.remove(dds);
  for_each_link([&](Link& link) { link.on_gone(now, dds); });
  look_for_all_soon(now);
}

// At once, or a moment after the last time: whoever announces many routers, or one again and again,
// keeps this one busy for a bounded time only.
void Links::look_for_all_soon(Time now) {
  if (now < looked_ + kLookEvery) {
    look_due_ = looked_ + kLookEvery;
    return;
  }
  looked_ = now;
  look_due_ = kNever;
  look_for_all(now);
}

void Links::look_for_all(Time now) {
  for_each_link([&](Link& link) { look_for(now, link); });
}

// The link came up: from now on it is bound to that router. Or it went down: any candidate may be
// used.
void Links::look_again(Time now, Link& link) {
  slots_[link.slot()].was_up = link.is_up();
  slots_[link.slot()].tries = 0;
  look_for(now, link);
}

// Gives a link the announced addresses of the router it is meant for.
void Links::look_for(Time now, Link& link) {
  touch(link);
  const std::vector<const Announcement*> candidates = fleet_.candidates(link, supers_.size() < 2);
  const bool automatic = link.settings().is_automatic();
  if (candidates.empty()) {
    link.set_targets(now, PathKind::kDds, {});
    slots_[link.slot()].standby = {};
    if (!automatic) return;
    link.set_targets(now, PathKind::kUdp, {});
    const std::string why = "the fleet has no router that is " + fleet_.looked_for();
    return link.note_no_candidate(why);
  }
  const Announcement& one = *candidates[slots_[link.slot()].tries % candidates.size()];
  // A restarted router may be announced while its previous instance still is.
  std::vector<NetAddress> udp;
  std::vector<NetAddress> dds;
  for (const Announcement* a : candidates) {
    if (a->identity.system != one.identity.system || a->identity.id != one.identity.id) continue;
    udp.insert(udp.end(), a->udp.begin(), a->udp.end());
    dds.push_back(a->dds);
  }
  if (automatic || !link.settings().connects) link.set_targets(now, PathKind::kUdp, udp);
  standby_turns_.prepare(now, link, fleet_.routers().size(), *this, slots_[link.slot()].standby,
                         dds);
  link.set_targets(now, PathKind::kDds, dds);
}

// --- choice of the super router

void Links::choose_uplink(Time now) {
  if (!std::exchange(choose_, false)) return;
  Link* best = nullptr;
  for (const std::uint32_t slot : supers_) {
    Link& link = *slots_[slot].link;
    const bool settled = now >= link.since() + kFailBackAfter || uplink_ == nullptr ||
                         !uplink_->is_up() || &link == uplink_;
    if (!link.is_up() || !settled) continue;
    best = &link;
    break;
  }
  if (best != uplink_) {
    uplink_before_ = std::exchange(uplink_, best);
    overlap_end_ = now + kOverlap;
  }
  router_.set_uplink(now, best == nullptr ? core::kNoClient : best->client());
  using Scope = Advertiser::Scope;
  for (const std::uint32_t slot : supers_) {
    Link& link = *slots_[slot].link;
    const bool leaving = &link == uplink_before_ && now < overlap_end_;
    link.set_scope(now, &link == best ? Scope::kAll
                        : leaving     ? Scope::kAsFarther
                                      : Scope::kNothing);
    touch(link);
  }
}

}  // namespace tims::link

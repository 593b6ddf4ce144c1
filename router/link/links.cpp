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
// A REFUSE is the longest answer that a stranger can get.
constexpr std::uint64_t kRefusalsPerSecond = 20;
// While this much waits in the control lane, no part of a list is added.
constexpr std::uint64_t kListBacklogMax = 64 << 10;

// A certificate is for one router.
bool is_named(const Identity& identity, const PeerName& certificate) {
  return identity.role == certificate.role && identity.system == certificate.system &&
         identity.id == certificate.id;
}

std::string name_mismatch(const Identity& identity, const PeerName& certificate) {
  const auto text = [](core::Role role, unsigned system, unsigned id) {
    return std::string(core::name(role)) + " " + std::to_string(system) + "/" + std::to_string(id);
  };
  return "the router is " + text(identity.role, identity.system, identity.id) +
         ", its certificate is for " + text(certificate.role, certificate.system, certificate.id);
}

}  // namespace

Links::Links(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
             const LinksSetup& setup, LinksShell* shell)
    : router_(router),
      pool_(pool),
      memory_(memory),
      setup_(setup),
      shell_(shell),
      packing_(setup.self.widths, setup.self.classes, setup.clock),
      admission_(router, setup.self, setup.secret),
      handshakes_(setup.handshaker, *this),
      lists_(*this),
      fleet_(setup.self),
      refusals_(kRefusalsPerSecond, kRefusalsPerSecond),
      scratch_(std::make_unique<std::byte[]>(kBurstBytesMax + kDatagramMax)) {}

// SipHash in counter mode: one number reveals nothing about the others.
std::uint64_t Links::random() { return core::sip_hash(setup_.secret, {++drawn_}); }

template <typename Datagram>
void Links::send_control(const NetAddress& to, const Datagram& datagram) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  send(to, std::span(bytes).first(encode(datagram, bytes)));
}

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
  settings.session.classes = setup_.self.classes;
  settings.secure = settings.secure && handshakes_.are_possible();
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

void Links::use_list(Time now, FleetListBytes list, const Accepted& accepted) {
  for_each_link([&](Link& link) {
    if (!link.keys().are_used() || accepted(link.certificate())) return;
    link.expel(now);
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
  return std::clamp<std::size_t>(session.rate() / 100, ListExchange::kPartMin,
                                 ListExchange::kPartMax);
}

void Links::check_list(std::uint64_t transfer, std::uint64_t number, std::uint32_t slot,
                       std::vector<std::byte>&& bytes) {
  setup_.lists->check(transfer, number, slots_[slot].link->peer().name.view(), std::move(bytes));
}

std::vector<std::string> Links::names_to_resolve() const {
  std::vector<std::string> names;
  for_each([&](const Link& link) {
    if (link.settings().connects && !link.is_up()) names.push_back(link.settings().to);
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
  if (ends_) return;
  if (const auto data = decode_data(bytes)) return on_data(now, from, *data);
  const auto datagram = decode(bytes);
  if (!datagram) {
    ++counters_.strange;
    return;
  }
  if (const auto* hello = std::get_if<Hello>(&*datagram)) return on_hello(now, from, *hello);
  if (const auto* hello = std::get_if<SealedHello>(&*datagram))
    return send_control(from, admission_.retry(now, from, hello->token, 0));
  if (const auto* crypto = std::get_if<Crypto>(&*datagram)) return on_crypto(now, from, *crypto);
  if (const auto* retry = std::get_if<Retry>(&*datagram)) {
    Link* link = by_token(retry->echo);
    if (link == nullptr) return;
    link->on_retry(now, from, *retry);
    return touch(*link);
  }
  if (const auto* welcome = std::get_if<Welcome>(&*datagram))
    return on_welcome(now, from, *welcome);
  if (const auto* refuse = std::get_if<Refuse>(&*datagram)) {
    Link* link = by_token(refuse->echo);
    if (link == nullptr) return;
    link->on_refuse(now, from, *refuse);
    return touch(*link);
  }
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
  ++counters_.unknown_token;
  send_control(from, Reset{token});
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
  const auto next = router_.next_hop(router_.client(from), message.header.dest);
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
  MessageBuffer room(memory_);
  if (*size > setup_.self.message_max || !room || !room.grow(*size)) {
    lost(link, message.header, core::Outcome::kIncomplete);
    return false;
  }
  if (!packing_.unpack(message, room.bytes().first(*size), counters)) return false;
  done_.push_back(std::move(room));
  return true;
}

std::uint64_t Links::queued_bytes(std::uint32_t token) const {
  const Link* link = this->link(token);
  return link == nullptr ? 0 : link->session().queued_bytes();
}

// --- time

void Links::on_timeout(Time now) {
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
  handshakes_.on_timeout(now);
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
  for_each_link(
      [&](Link& link) { link.take_down(now, Link::State::kDown, core::CloseReason::kShutdown); });
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

// --- admission

void Links::on_hello(Time now, const NetAddress& from, const Hello& hello) {
  if (const auto refusal = Admission::version_refusal(hello)) return refuse(now, {from}, *refusal);
  const Link* link = link_to(hello.identity);
  const bool resumes = link != nullptr && !link->settings().secure && link->is_of_session(hello);
  const std::uint64_t epoch = hello.identity.epoch;
  // Nothing is stored, looked up or sent at length for an unverified address.
  if (!resumes && !admission_.is_proven(now, from, hello.token, epoch, hello.cookie))
    return send_control(from, admission_.retry(now, from, hello.token, epoch));
  admit(now, {from}, hello);
}

void Links::admit(Time now, const Caller& caller, const Hello& hello) {
  const NetAddress& from = caller.address;
  // Both sides connect: accept a router that is at an address we connect to, or that we were
  // linked with.
  const auto is_called = [&](const LinkSettings& s) {
    return first_link([&](const Link& l) {
             return l.settings().to == s.to &&
                    (l.paths().is_target(from) || l.is_to(hello.identity));
           }) != nullptr;
  };
  Refuse refusal{.echo = hello.token};
  const LinkSettings* settings = admission_.accepting(settings_, from, hello, is_called, refusal);
  // Over DDS, the router a link connects to is known by its announcement, which may arrive after
  // its HELLO.
  const bool may_be_called =
      refusal.code == RefuseCode::kNotConfigured && from.kind == PathKind::kDds;
  if (settings == nullptr && may_be_called && !fleet_.routers().contains(from)) return;
  Link* link = link_to(hello.identity);
  if (settings != nullptr && link != nullptr && link->is_up() &&
      link->settings().secure != settings->secure) {
    refusal = admission_.refusal(hello, RefuseCode::kDuplicateId,
                                 settings->secure ? " is linked with this router without keys"
                                                  : " is linked with this router with keys");
    settings = nullptr;
  }
  if (settings == nullptr) {
    admission_.note_refused(now, from, hello.identity, refusal.text.view());
    return refuse(now, caller, refusal);
  }
  // Both sides connect to each other: the call of the lower address is used.
  if (settings->connects && setup_.self.address() < hello.identity.address()) return;
  if (link != nullptr && link->is_of_session(hello)) {
    Verified verified;
    if (caller.handshake != nullptr) verified = std::move(caller.handshake->verified);
    const std::uint8_t generation = link->resume(now, hello, std::move(verified));
    touch(*link);
    return welcome(now, caller, hello, *link, generation);
  }
  if (link == nullptr && settings->connects) link = find(settings->to);
  if (const auto full = reason_against(now, caller, hello, link)) {
    return full->text.view().empty() ? void() : refuse(now, caller, *full);
  }
  take(now, caller, hello, link == nullptr ? add(now, *settings) : *link);
}

// A refusal, or an empty one when the caller has to wait; nothing when it may be taken. `link`: the
// one that it would continue; null: a new one.
std::optional<Refuse> Links::reason_against(Time now, const Caller& caller, const Hello& hello,
                                            const Link* link) {
  Refuse refusal{.echo = hello.token};
  if (link != nullptr && link->state() == Link::State::kDown)
    return admission_.refusal(hello, RefuseCode::kNotConfigured,
                              " has taken this link down manually");
  if (link != nullptr && link->peer().epoch != 0) {
    switch (admission_.rival(now, caller.address, hello, *link, refusal)) {
      case Admission::Rival::kNone:
        break;
      case Admission::Rival::kWait:
        // A HELLO comes again by itself.
        if (caller.handshake != nullptr)
          Handshakes::ask_again(now, *caller.handshake, hello.keep_alive);
        return refusal;
      case Admission::Rival::kRefuse:
        return refusal;
    }
  }
  if (link != nullptr || links_in_use() < setup_.links_max) return std::nullopt;
  refusal =
      admission_.refusal(hello, RefuseCode::kTooMany,
                         " has as many links as it can hold: " + std::to_string(setup_.links_max));
  admission_.note_refused(now, caller.address, hello.identity, refusal.text.view());
  return refusal;
}

std::size_t Links::links_in_use() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(slots_, [](const Slot& slot) { return slot.link != nullptr; }));
}

// `resumed`: the generation of the keys with which a session continues.
void Links::welcome(Time now, const Caller& caller, const Hello& hello, const Link& link,
                    std::optional<std::uint8_t> resumed) {
  const bool sealed = caller.handshake != nullptr;
  const Welcome welcome{.version = sealed ? kVersionSealed : kVersionPlain,
                        .resumed = resumed.has_value(),
                        .generation = resumed.value_or(0),
                        .echo = hello.token,
                        .token = link.our_token(),
                        .keep_alive = link.settings().keep_alive,
                        .identity = setup_.self,
                        .codecs = kCodecs};
  sealed ? answer(now, *caller.handshake, welcome) : send_control(caller.address, welcome);
}

template <typename Datagram>
void Links::answer(Time now, Handshakes::One& handshake, const Datagram& datagram) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  handshakes_.answer(now, handshake, std::span(bytes).first(encode(datagram, bytes)));
}

void Links::take(Time now, const Caller& caller, const Hello& hello, Link& link) {
  admission_.forget_rivals(hello.identity);
  Verified verified;
  if (caller.handshake != nullptr) verified = std::move(caller.handshake->verified);
  link.accept(now, caller.address, hello, random() | 1, std::move(verified));
  index(link);
  touch(link);
  welcome(now, caller, hello, link, std::nullopt);
}

Link* Links::link_to(const Identity& identity) {
  const auto found = peers_.find(identity.address().raw());
  if (found == peers_.end()) return nullptr;
  Link* link = slots_[found->second].link.get();
  return link->is_to(identity) ? link : nullptr;
}

void Links::refuse(Time now, const Caller& caller, const Refuse& refusal) {
  ++counters_.refused;
  if (caller.handshake != nullptr) return answer(now, *caller.handshake, refusal);
  if (refusals_.try_take(now)) send_control(caller.address, refusal);
}

// --- handshakes

void Links::on_crypto(Time now, const NetAddress& from, const Crypto& crypto) {
  if (handshakes_.on_crypto(now, from, crypto) || crypto.from_accepting || crypto.offset != 0)
    return;
  if (!admission_.is_proven(now, from, crypto.token, 0, crypto.cookie)) return;
  if (handshakes_.are_possible()) {
    // Without room, the first part of the handshake comes again.
    (void)handshakes_.accept(now, from, crypto);
    return;
  }
  constexpr std::string_view kNoKeys =
      "this router has no keys: timsctl join on its host, or secure = false in the [[link]] of "
      "both";
  admission_.note_refused(now, from, {}, kNoKeys);
  refuse(now, {from}, {.echo = crypto.token, .code = RefuseCode::kVersion, .text = kNoKeys});
}

void Links::on_message(Time now, Handshakes::One& handshake) {
  if (handshake.side == Handshaker::Side::kAccepts) return on_who(now, handshake);
  const auto datagram = decode(handshake.message);
  if (datagram) {
    if (const auto* welcome = std::get_if<Welcome>(&*datagram))
      on_welcome(now, handshake.address, *welcome, &handshake);
    Link* link = by_token(handshake.token);
    const auto* refuse = std::get_if<Refuse>(&*datagram);
    if (refuse != nullptr && link != nullptr) {
      link->on_refuse(now, handshake.address, *refuse);
      touch(*link);
    }
  }
  handshakes_.finish(now, handshake);
}

void Links::on_who(Time now, Handshakes::One& handshake) {
  const auto hello = decode_who(handshake.message);
  const Caller caller{handshake.address, &handshake};
  if (!hello || hello->token != handshake.token || hello->version_max != kVersionSealed)
    return refuse(now, caller, {.echo = handshake.token, .code = RefuseCode::kVersion});
  const PeerName& peer = handshake.verified.peer;
  if (is_named(hello->identity, peer)) return admit(now, caller, *hello);
  const std::string why = name_mismatch(hello->identity, peer);
  admission_.note_refused(now, handshake.address, hello->identity, why);
  refuse(now, caller,
         {.echo = hello->token, .code = RefuseCode::kCertificate, .text = std::string_view(why)});
}

// Both sides log the reason.
void Links::on_failed(Time now, const Handshakes::One& handshake, std::string_view why) {
  const Refuse refusal{.echo = handshake.token, .code = RefuseCode::kCertificate, .text = why};
  if (handshake.side == Handshaker::Side::kAccepts) {
    admission_.note_refused(now, handshake.address, {}, why);
    return refuse(now, {handshake.address}, refusal);
  }
  Link* link = by_token(handshake.token);
  if (link == nullptr) return;
  link->on_refuse(now, handshake.address, refusal);
  touch(*link);
}

// --- routers of the fleet

void Links::on_announced(Time now, const Announcement& announcement) {
  if (!fleet_.add(announcement)) return;
  const Identity& identity = announcement.identity;
  if (fleet_.is_double(identity))
    router_.note({.at = now,
                  .kind = core::EventKind::kDuplicateRouter,
                  .address = identity.address(),
                  .client = link_peer(identity.name.view(), announcement.dds.to_string()),
                  .owner = link_peer(setup_.self.name.view(), "this router")});
  look_for_all(now);
}

void Links::on_gone(Time now, const NetAddress& dds) {
  fleet_.remove(dds);
  for_each_link([&](Link& link) { link.on_gone(now, dds); });
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

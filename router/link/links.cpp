#include "router/link/links.h"

#include <algorithm>
#include <utility>

#include "router/core/random.h"
#include "wire/header.h"

namespace tims::link {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kBurstsPerTurn = 16;  // of one link, before others have theirs
// Differentiated services (RFC 4594): EF for what is urgent, AF41 and AF31 below, CS1 for texts.
// Neither AF21 nor AF11: Linux before 6.8 sends those on Wi-Fi as background, like CS1.
constexpr std::array<std::uint8_t, kLanes> kDscp{8, 0, 0, 26, 34, 46, 46, 46, 48};

// A cookie is good in the period it was made in, and in the next one.
constexpr Duration kCookiePeriod = std::chrono::seconds(5);
// Two routers with one name: how long the first is given to show that it lives, in keep-alives.
constexpr int kRivalKeepAlives = 2;
constexpr Duration kRivalForgotten = std::chrono::seconds(10);
// One that is refused again and again is named so often, and at most so many at a time.
constexpr Duration kRefusedAgain = std::chrono::seconds(10);
constexpr std::size_t kRefusedMax = 64;

std::string text_of(const Identity& who) {
  return who.address().to_string(who.widths) + " " + std::string(who.name.view());
}

// The role a router above (or beside) one of this role has.
bool fits(LinkKind kind, Role lower, Role upper) {
  if (kind == LinkKind::kPeer) return lower == upper && lower != Role::kSubsystem;
  return (lower == Role::kSubsystem && upper == Role::kSystem) ||
         (lower == Role::kSystem && upper == Role::kTop);
}

std::string systems_text(const std::vector<LinkSettings>& settings) {
  std::string text;
  for (const LinkSettings& s : settings) {
    if (s.connects) continue;
    text += (text.empty() ? "" : ", ") + (s.system ? std::to_string(*s.system) : std::string("*"));
  }
  return text;
}

// Keep-alives, 9 s: so long has UDP to bring up a link to a new router. Of a fleet that starts at
// once on a busy machine some take seconds, which is not the time to begin with DDS.
constexpr int kUdpFirst = 30;
constexpr Duration kStandbySpacing = 500ms;  // of each router of the fleet, to prepare a DDS path
// With more routers in the fleet none is prepared before it is needed.
constexpr std::size_t kStandbyFleetMax = 100;

// A more preferred super router must have been up for so long before it is used again.
constexpr Duration kFailBackAfter = std::chrono::milliseconds(500);
// So long the one used before still knows what is below us: what is on its way finds us.
constexpr Duration kOverlap = std::chrono::seconds(1);

}  // namespace

Links::Links(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
             const LinksSetup& setup, LinksShell* shell)
    : router_(router),
      pool_(pool),
      memory_(memory),
      setup_(setup),
      secret_{setup.seed, core::spread(setup.seed)},
      shell_(shell),
      fleet_(setup.self),
      scratch_(std::make_unique<std::byte[]>(kBurstBytesMax + kDatagramMax)) {
  dds_budget_.set(kDdsPathsPerSecond, kDdsPathsPerSecond);
}

std::uint64_t Links::random() { return core::sip_hash(secret_, {++drawn_}); }

// --- configuration

void Links::configure(Time now, std::span<const LinkSettings> wanted) {
  settings_.assign(wanted.begin(), wanted.end());
  supers_.clear();
  const auto find_wanted = [&](const Link& link) {
    return std::ranges::find_if(settings_, [&](const LinkSettings& s) {
      return s.kind == link.settings().kind && s.connects == link.settings().connects &&
             s.to == link.settings().to && s.system == link.settings().system;
    });
  };
  for (std::uint32_t slot = 0; slot < links_.size(); ++slot) {
    if (!links_[slot]) continue;
    const auto same = find_wanted(*links_[slot]);
    if (same == settings_.end()) {
      remove(now, slot);
    } else {
      links_[slot]->configure(now, own_settings(*same));
    }
  }
  for (const LinkSettings& settings : settings_) {
    if (!settings.connects) continue;
    const auto there = std::ranges::find_if(links_, [&](const auto& link) {
      return link && link->settings().connects && link->settings().to == settings.to;
    });
    const Link& link = there == links_.end() ? add(settings) : **there;
    if (settings.kind == LinkKind::kSuper) supers_.push_back(link.slot());
  }
  choose_ = true;
  look_for_all(now);
}

LinkSettings Links::own_settings(LinkSettings settings) const {
  settings.session.message_max = setup_.self.message_max;
  settings.session.classes = setup_.self.classes;
  return settings;
}

Link& Links::add(const LinkSettings& settings) {
  std::uint32_t slot = 0;
  while (slot < links_.size() && links_[slot]) ++slot;
  if (slot == links_.size()) {
    links_.emplace_back();
    is_touched_.push_back(false);
    wakes_at_.push_back(kNever);
    tries_.push_back(0);
    were_up_.push_back(false);
    token_of_.push_back(0);
    standbys_.emplace_back();
  }
  LinkSurroundings& around = *this;
  links_[slot] =
      std::make_unique<Link>(router_, pool_, memory_, done_, around, slot, own_settings(settings));
  return *links_[slot];
}

void Links::remove(Time now, std::uint32_t slot) {
  Link& link = *links_[slot];
  link.take_down(now);
  report_losses(now);
  tokens_.erase(std::exchange(token_of_[slot], 0));
  std::erase(touched_, &link);
  is_touched_[slot] = were_up_[slot] = false;
  tries_[slot] = 0;
  standbys_[slot] = {};
  if (uplink_ == &link) uplink_ = nullptr;
  std::erase(supers_, slot);
  links_[slot].reset();
  choose_ = true;
}

void Links::set_targets(Time now, const std::string& to, PathKind kind,
                        std::span<const NetAddress> targets) {
  for (const auto& link : links_) {
    if (!link || !link->settings().connects || link->settings().to != to) continue;
    link->set_targets(now, kind, targets);
    touch(*link);
  }
}

void Links::network_changed(Time now) {
  for (const auto& link : links_) {
    if (!link) continue;
    link->call_now(now);
    touch(*link);
  }
}

std::vector<std::string> Links::wants_addresses() const {
  std::vector<std::string> names;
  for_each([&](const Link& link) {
    if (link.settings().connects && !link.is_up()) names.push_back(link.settings().to);
  });
  return names;
}

// --- what comes in

Link* Links::by_token(std::uint64_t token) {
  const auto found = tokens_.find(token);
  if (found == tokens_.end()) return nullptr;
  Link* link = links_[found->second].get();
  return link->our_token() == token ? link : nullptr;
}

void Links::touch(Link& link) {
  if (is_touched_[link.slot()]) return;
  is_touched_[link.slot()] = true;
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
  if (const auto* retry = std::get_if<Retry>(&*datagram)) {
    if (Link* link = by_token(retry->echo)) link->on_retry(from, *retry);
    return;
  }
  if (const auto* welcome = std::get_if<Welcome>(&*datagram))
    return on_welcome(now, from, *welcome);
  if (const auto* refuse = std::get_if<Refuse>(&*datagram)) {
    Link* link = by_token(refuse->echo);
    if (link == nullptr) return;
    link->on_refuse(now, from, *refuse);
    return touch(*link);
  }
  // Only who has seen our datagrams can know what token we put into them.
  const std::uint64_t token = std::get<Reset>(*datagram).token;
  for (const auto& link : links_) {
    if (!link || token == 0 || link->their_token() != token) continue;
    // We also ask where the other router only may be: others there do not know us.
    if (link->paths().is_strange(from)) continue;
    link->on_reset(now);
    touch(*link);
  }
}

void Links::on_data(Time now, const NetAddress& from, const Data& data) {
  const std::uint64_t token = data.header.token;
  if (Link* link = by_token(token)) {
    link->on_data(now, from, data);
    return touch(*link);
  }
  ++counters_.unknown_token;
  std::array<std::byte, kControlDatagramMax> bytes{};
  send(from, std::span(bytes).first(encode(Reset{token}, bytes)));
}

void Links::on_welcome(Time now, const NetAddress& from, const Welcome& welcome) {
  Link* link = by_token(welcome.echo);
  if (link == nullptr || link->is_up()) return;
  const auto told = [&](const std::string& text) {
    link->on_refuse(now, from, {.echo = welcome.echo, .text = std::string_view(text)});
    touch(*link);
  };
  if (welcome.version < kVersionMin || welcome.version > kVersionMax)
    return told("it speaks version " + std::to_string(welcome.version) + " of the protocol");
  if (welcome.who.widths != setup_.self.widths)
    return told("the widths of its address fields differ: see [address] widths");
  if (welcome.who.classes != setup_.self.classes)
    return told("its message.classes are " + welcome.who.classes.to_string() + ", here " +
                setup_.self.classes.to_string());
  const Link* other = link_to(welcome.who);
  if (other != nullptr && other != link && other->is_up())
    return told("there is a link to " + std::string(welcome.who.name.view()) + " already, to " +
                other->address().to_string());
  link->on_welcome(now, from, welcome);
}

// --- what the router decides

core::Outcome Links::deliver(Time now, const core::Receiver& to, const core::Message& message) {
  Link& link = *links_[to.token];
  touch(link);
  return link.send(now, message);
}

void Links::reply(Time now, const core::Receiver& to, const Header& header) {
  std::array<std::byte, kHeaderSize> bytes{};
  wire::encode_header(header, bytes);
  const core::Outcome outcome = deliver(now, to, {.header = header, .bytes = bytes});
  if (!core::taken(outcome)) lost(links_[to.token]->client(), header, outcome);
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
    if (wakes_at_[wake.slot] == wake.at) wakes_at_[wake.slot] = kNever;
    Link* link = links_[wake.slot].get();
    if (link == nullptr) continue;
    if (link->settings().is_automatic() && link->gives_up()) {
      ++tries_[wake.slot];
      look_for(now, *link);
    }
    if (standbys_[wake.slot].at <= now) look_for(now, *link);
    link->on_timeout(now);
    link->is_gone(now) ? remove(now, wake.slot) : touch(*link);
  }
  // A super router that has been up for long enough.
  if (supers_.size() > 1) choose_ = true;
}

void Links::learn_token(Link& link) {
  const std::uint64_t before = std::exchange(token_of_[link.slot()], link.our_token());
  if (before == link.our_token()) return;
  tokens_.erase(before);
  tokens_[link.our_token()] = link.slot();
}

// --- what is told

void Links::advertise(Time now) {
  // Nobody is told while nothing has changed, and those below never are.
  const std::uint32_t number = router_.exported_table().number();
  const bool news = std::exchange(advertised_, number) != number;
  const auto advertise_one = [&](Link& link) {
    if (link.is_up() && link.settings().kind != LinkKind::kSub) link.advertise(now);
  };
  if (!news) {
    for (Link* link : touched_) advertise_one(*link);
    return;
  }
  for (const auto& link : links_) {
    if (!link || !link->is_up() || link->settings().kind == LinkKind::kSub) continue;
    link->advertise(now);
    touch(*link);
  }
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

// --- what goes out

void Links::send(const NetAddress& to, std::span<const std::byte> datagram) {
  if (datagram.empty() || !to || singles_.size() >= 4096) return;
  Single& single = singles_.emplace_back();
  single.to = to;
  single.size = static_cast<std::uint32_t>(datagram.size());
  std::ranges::copy(datagram, single.bytes.begin());
}

// What nothing carries is lost, as it might be on its way.
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
      // A burst's datagrams are of one size but the last. One that is not full is the last, or
      // something else begins behind it.
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
    // One that the socket does not take is lost, as it might be on its way.
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

// False: it has more to send.
bool Links::flush_link(Time now, Link& link) {
  if (!send_bursts(now, link)) return false;
  std::span probe(scratch_.get(), kDatagramMax);
  const std::size_t size = link.build_probe(now, probe);
  if (size > 0)
    (void)offer({.to = link.address(), .bytes = probe.first(size), .datagram_size = size});
  if (were_up_[link.slot()] != link.is_up()) look_anew(now, link);
  is_touched_[link.slot()] = false;
  learn_token(link);
  const Time at = std::min(standbys_[link.slot()].at, link.next_timeout(now));
  if (at < wakes_at_[link.slot()]) {
    wakes_at_[link.slot()] = at;
    wake_.push({at, link.slot()});
  }
  return true;
}

void Links::end(Time now) {
  ends_ = true;
  for (const auto& link : links_)
    if (link) link->take_down(now, Link::State::kDown, core::CloseReason::kShutdown);
}

// --- by hand

Link* Links::find(std::string_view name) {
  for (const auto& link : links_) {
    if (link && (link->peer().name.view() == name || link->settings().to == name ||
                 link->address().to_string() == name))
      return link.get();
  }
  return nullptr;
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

// --- who may connect

void Links::on_hello(Time now, const NetAddress& from, const Hello& hello) {
  Refuse refuse{.echo = hello.token};
  if (hello.version_min > kVersionMax || hello.version_max < kVersionMin) {
    refuse.text = std::string_view("this router speaks version " + std::to_string(kVersionMin) +
                                   " to " + std::to_string(kVersionMax) +
                                   " of the protocol, yours " + std::to_string(hello.version_min) +
                                   " to " + std::to_string(hello.version_max));
    return this->refuse(from, refuse);
  }
  Link* link = link_to(hello.who);
  const bool resumes = link != nullptr && link->is_of_session(hello);
  // Nothing is kept, looked up or said at length for somebody who may not be there.
  if (!resumes && !is_proven(now, from, hello)) return ask_again(now, from, hello);
  const LinkSettings* settings = accepting(from, hello, refuse);
  // Over DDS, whom a link calls is known by its announcement, which may come after its HELLO.
  const bool may_be_called =
      refuse.code == RefuseCode::kNotConfigured && from.kind == PathKind::kDds;
  if (settings == nullptr && may_be_called && !fleet_.routers().contains(from)) return;
  if (settings == nullptr) {
    note_refused(now, from, hello, refuse);
    return this->refuse(from, refuse);
  }
  // Both call each other: the lower address's call counts.
  if (settings->connects && setup_.self.address() < hello.who.address()) return;
  if (resumes) {
    link->resume(hello);
    return welcome(from, hello, *link, true);
  }
  if (link == nullptr && settings->connects) link = find(settings->to);
  if (link != nullptr && link->state() == Link::State::kDown) {
    const std::string text = text_of(setup_.self) + " has taken this link down by hand";
    refuse.code = RefuseCode::kNotConfigured;
    refuse.text = std::string_view(text);
    return this->refuse(from, refuse);
  }
  if (link != nullptr && link->peer().epoch != 0) {
    switch (rival(now, from, hello, *link, refuse)) {
      case Rival::kNone:
        break;
      case Rival::kWait:
        return;
      case Rival::kRefuse:
        return this->refuse(from, refuse);
    }
  }
  if (link == nullptr && links_in_use() >= setup_.links_max) {
    const std::string text = text_of(setup_.self) + " has as many links as it can hold: " +
                             std::to_string(setup_.links_max);
    refuse.code = RefuseCode::kTooMany;
    refuse.text = std::string_view(text);
    note_refused(now, from, hello, refuse);
    return this->refuse(from, refuse);
  }
  take(now, from, hello, link == nullptr ? add(*settings) : *link);
}

// --- the proof of an address

// As in DTLS (RFC 9147, section 5.1): made from what is in the HELLO, so that nothing is kept of
// it.
std::uint64_t Links::cookie(const NetAddress& from, const Hello& hello, Duration period) const {
  std::array<std::uint64_t, 2> ip{};
  for (std::size_t i = 0; i < from.ip.size(); ++i) ip[i / 8] = ip[i / 8] << 8 | from.ip[i];
  const std::uint64_t place =
      std::uint64_t{from.scope} << 32 | std::uint64_t{from.port} << 8 | index(from.kind);
  const auto number = static_cast<std::uint64_t>(period / kCookiePeriod);
  return core::sip_hash(secret_, {ip[0], ip[1], place, hello.token, hello.who.epoch, number});
}

bool Links::is_proven(Time now, const NetAddress& from, const Hello& hello) const {
  const Duration period = now.time_since_epoch();
  return hello.cookie == cookie(from, hello, period) ||
         hello.cookie == cookie(from, hello, period - kCookiePeriod);
}

void Links::ask_again(Time now, const NetAddress& from, const Hello& hello) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const Retry retry{hello.token, cookie(from, hello, now.time_since_epoch())};
  send(from, std::span(bytes).first(encode(retry, bytes)));
}

std::size_t Links::links_in_use() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(links_, [](const auto& link) { return link != nullptr; }));
}

// The setting under which this router may connect; else `refuse` says why not.
const LinkSettings* Links::accepting(const NetAddress& from, const Hello& hello,
                                     Refuse& refuse) const {
  const Identity& self = setup_.self;
  const Identity& who = hello.who;
  const auto no = [&](RefuseCode code, const std::string& text) {
    refuse.code = code;
    refuse.text = std::string_view(text);
    return nullptr;
  };
  if (who.epoch == self.epoch) return no(RefuseCode::kDuplicateId, "this is the router itself");
  if (who.system == self.system && who.id == self.id)
    return no(RefuseCode::kDuplicateId,
              text_of(self) + " has this system and id already: choose another [router] id");
  if (who.widths != self.widths)
    return no(RefuseCode::kWidths,
              text_of(self) + " has other address fields: see [address] widths");
  if (who.classes != self.classes)
    return no(RefuseCode::kClasses, text_of(self) + " has message.classes " +
                                        self.classes.to_string() + ", not " +
                                        who.classes.to_string());
  const LinkKind ours = hello.kind == LinkKind::kSuper ? LinkKind::kSub : LinkKind::kPeer;
  if (!fits(hello.kind, who.role, self.role))
    return no(RefuseCode::kRole, text_of(self) + " is a " + std::string(name(self.role)) +
                                     " router, which is no " + std::string(name(hello.kind)) +
                                     " router for a " + std::string(name(who.role)) + " router");
  bool any_of_kind = false;
  bool other_path = false;
  for (const LinkSettings& s : settings_) {
    if (s.kind != ours) continue;
    if (std::ranges::find(s.paths, from.kind) == s.paths.end()) {
      other_path = true;
      continue;
    }
    if (s.connects) {
      // Both sides connect: whoever comes first from where we call, or whom we were linked with.
      const auto same = std::ranges::find_if(links_, [&](const auto& link) {
        return link && link->settings().to == s.to &&
               (link->paths().is_target(from) || link->is_to(who));
      });
      if (same != links_.end()) return &s;
      continue;
    }
    any_of_kind = true;
    if (!s.system || *s.system == who.system) return &s;
  }
  if (!any_of_kind && other_path)
    return no(RefuseCode::kNotConfigured,
              text_of(self) + " takes no link over " + std::string(name(from.kind)) +
                  ": see paths of its [[link]] with kind = \"" + std::string(name(ours)) + "\"");
  if (!any_of_kind)
    return no(RefuseCode::kNotConfigured,
              text_of(self) + " has no [[link]] with kind = \"" + std::string(name(ours)) + "\"");
  return no(RefuseCode::kSystem, text_of(self) + " accepts system " + systems_text(settings_) +
                                     ", not " + std::to_string(who.system));
}

// Somebody with this system and id is linked already. It may have been started anew; or there are
// two of them.
Links::Rival Links::rival(Time now, const NetAddress& from, const Hello& hello, Link& link,
                          Refuse& refuse) {
  const std::uint32_t address = hello.who.address().raw();
  // Who knows our token is the one it was given to. An epoch is no secret.
  const bool same = link.paths().is_at(from) || hello.resume == link.our_token();
  if (same || !link.is_up()) {
    conflicts_.erase(address);
    return Rival::kNone;
  }
  const Duration patience = kRivalKeepAlives * link.their_keep_alive();
  auto [conflict, first] = conflicts_.try_emplace(address, now);
  if (now > conflict->second + kRivalForgotten) conflict->second = now;
  if (link.heard() <= conflict->second) {
    return now > conflict->second + patience ? Rival::kNone : Rival::kWait;
  }
  if (!first && now <= conflict->second + patience / 2) return Rival::kWait;
  refuse.code = RefuseCode::kDuplicateId;
  refuse.text = std::string_view(text_of(link.peer()) + " at " + link.address().to_string() +
                                 " lives and has this system and id: choose another [router] id");
  router_.note({.at = now,
                .kind = core::EventKind::kDuplicateRouter,
                .address = hello.who.address(),
                .client = {.id = {},
                           .port = core::PortKind::kLink,
                           .name = core::Text<31>(hello.who.name.view()),
                           .endpoint = std::string_view(from.to_string())},
                .owner = {.id = link.client(),
                          .port = core::PortKind::kLink,
                          .name = core::Text<31>(link.peer().name.view()),
                          .endpoint = std::string_view(link.address().to_string())}});
  return Rival::kRefuse;
}

void Links::welcome(const NetAddress& to, const Hello& hello, const Link& link, bool resumed) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const Welcome welcome{.resumed = resumed,
                        .echo = hello.token,
                        .token = link.our_token(),
                        .keep_alive = link.settings().keep_alive,
                        .who = setup_.self};
  send(to, std::span(bytes).first(encode(welcome, bytes)));
}

void Links::take(Time now, const NetAddress& from, const Hello& hello, Link& link) {
  conflicts_.erase(hello.who.address().raw());
  link.accept(now, from, hello, random() | 1);
  learn_token(link);
  touch(link);
  welcome(from, hello, link, false);
}

void Links::refuse(const NetAddress& to, const Refuse& refuse) {
  ++counters_.refused;
  std::array<std::byte, kControlDatagramMax> bytes{};
  send(to, std::span(bytes).first(encode(refuse, bytes)));
}

void Links::note_refused(Time now, const NetAddress& from, const Hello& hello,
                         const Refuse& refuse) {
  std::erase_if(refused_, [&](const auto& r) { return now >= r.second + kRefusedAgain; });
  if (refused_.size() >= kRefusedMax) return;
  if (!refused_.try_emplace(hello.who.address().raw(), now).second) return;
  router_.note({.at = now,
                .kind = core::EventKind::kLinkRefused,
                .address = hello.who.address(),
                .client = {.id = {},
                           .port = core::PortKind::kLink,
                           .name = core::Text<31>(hello.who.name.view()),
                           .endpoint = std::string_view(from.to_string())},
                .text = refuse.text});
}

Link* Links::link_to(const Identity& who) {
  for (const auto& link : links_) {
    if (link && link->is_to(who)) return link.get();
  }
  return nullptr;
}

// --- routers of the fleet

void Links::on_announced(Time now, const Announcement& announcement) {
  if (!fleet_.add(announcement)) return;
  const Identity& who = announcement.who;
  if (fleet_.is_double(who))
    router_.note({.at = now,
                  .kind = core::EventKind::kDuplicateRouter,
                  .address = who.address(),
                  .client = {.port = core::PortKind::kLink,
                             .name = core::Text<31>(who.name.view()),
                             .endpoint = std::string_view(announcement.dds.to_string())},
                  .owner = {.port = core::PortKind::kLink,
                            .name = core::Text<31>(setup_.self.name.view()),
                            .endpoint = std::string_view("this router")}});
  look_for_all(now);
}

void Links::on_gone(Time now, const NetAddress& dds) {
  fleet_.remove(dds);
  for (const auto& link : links_) {
    if (link) link->on_gone(now, dds);
  }
  look_for_all(now);
}

void Links::look_for_all(Time now) {
  for (const auto& link : links_) {
    if (link) look_for(now, *link);
  }
}

// It has come up: that one is meant from now on. Or it is down: any may be.
void Links::look_anew(Time now, Link& link) {
  were_up_[link.slot()] = link.is_up();
  tries_[link.slot()] = 0;
  look_for(now, link);
}

// What a path over DDS costs the router above grows with how many it has already. So where UDP is
// there as well, routers that start at once take turns, each side by itself, and none prepares more
// than a few a second. A link that is down although UDP had time enough needs this path now, and
// goes before those that only take their turn; but when all are too busy to answer they are all
// down, so no more are prepared a second for it. In a large fleet nobody has a turn: what many
// paths ask of the router above while nobody needs them is what it then lacks to hear its links.
Time Links::standby_at(Time now, const Link& link, Standby& standby) {
  if (!link.is_up() && !link.settings().connects) return kNever;  // it calls nobody
  if (standby.since == kNever) {
    std::uint64_t drawn = random();
    standby.since = now;
    standby.share = core::next_share(drawn);
  }
  const std::size_t others = fleet_.routers().size();
  const auto all = static_cast<double>(others) * kStandbySpacing;
  const Duration keep_alive = link.settings().keep_alive;
  const Time standby_turn_at =
      others > kStandbyFleetMax
          ? kNever
          : standby.since + keep_alive + std::chrono::duration_cast<Duration>(standby.share * all);
  const Time needed_at =
      link.is_up() ? kNever
                   : std::max(standby.since + kUdpFirst * keep_alive, link.since() + keep_alive);
  if (now < std::min(standby_turn_at, needed_at)) return std::min(standby_turn_at, needed_at);
  const Time ready_at = dds_budget_.ready_at(now);
  if (now < needed_at) return std::max(ready_at, dds_needed_until_);
  if (now < ready_at) dds_needed_until_ = ready_at + 1s / kDdsPathsPerSecond;
  return ready_at;
}

// Leaves those to which the path may be prepared now.
void Links::prepare_standby(Time now, const Link& link, std::vector<NetAddress>& dds) {
  Standby& standby = standbys_[link.slot()];
  const auto waits = [&](const NetAddress& to) {
    return std::ranges::find(standby.prepared, to) == standby.prepared.end();
  };
  const Path* udp = link.paths().find(PathKind::kUdp);
  const bool by_dds = link.is_up() && link.paths().kind() == PathKind::kDds;
  standby.at = kNever;
  if (udp != nullptr && !udp->targets.empty() && !by_dds && std::ranges::any_of(dds, waits)) {
    standby.at = standby_at(now, link, standby);
    if (standby.at > now) {
      std::erase_if(dds, waits);
      return;
    }
    dds_budget_.take(1);
  }
  standby = {.prepared = dds};
}

// Tells a link where the router it means has announced to be.
void Links::look_for(Time now, Link& link) {
  touch(link);
  const std::vector<const Announcement*> candidates = fleet_.candidates(link, supers_.size() < 2);
  const bool automatic = link.settings().is_automatic();
  if (candidates.empty()) {
    link.set_targets(now, PathKind::kDds, {});
    standbys_[link.slot()] = {};
    if (!automatic) return;
    link.set_targets(now, PathKind::kUdp, {});
    const std::string why = "nobody in the fleet is " + fleet_.looked_for();
    return link.note_nobody(why);
  }
  const Announcement& one = *candidates[tries_[link.slot()] % candidates.size()];
  // A router that was started anew is heard of while its former life still is.
  std::vector<NetAddress> udp;
  std::vector<NetAddress> dds;
  for (const Announcement* a : candidates) {
    if (a->who.system != one.who.system || a->who.id != one.who.id) continue;
    udp.insert(udp.end(), a->udp.begin(), a->udp.end());
    dds.push_back(a->dds);
  }
  if (automatic || !link.settings().connects) link.set_targets(now, PathKind::kUdp, udp);
  prepare_standby(now, link, dds);
  link.set_targets(now, PathKind::kDds, dds);
}

// --- which super router is used

void Links::choose_uplink(Time now) {
  if (!std::exchange(choose_, false)) return;
  Link* best = nullptr;
  for (const std::uint32_t slot : supers_) {
    Link& link = *links_[slot];
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
    Link& link = *links_[slot];
    const bool leaving = &link == uplink_before_ && now < overlap_end_;
    link.set_scope(now, &link == best ? Scope::kAll
                        : leaving     ? Scope::kAsFarther
                                      : Scope::kNothing);
    touch(link);
  }
}

}  // namespace tims::link

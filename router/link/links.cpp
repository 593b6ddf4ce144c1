#include "router/link/links.h"

#include <algorithm>
#include <utility>

#include "wire/header.h"

namespace tims::link {
namespace {

constexpr std::size_t kTrainsPerTurn = 16;  // of one link, before others have theirs
// Differentiated services (RFC 4594): EF for what is urgent, AF41 and AF31 below, CS1 for texts.
// Neither AF21 nor AF11: Linux before 6.8 sends those on Wi-Fi as background, like CS1.
constexpr std::array<std::uint8_t, kLanes> kDscp{8, 0, 0, 26, 34, 46, 46, 46, 48};

}  // namespace

Links::Links(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
             const LinksSetup& setup)
    : router_(router),
      pool_(pool),
      memory_(memory),
      setup_(setup),
      secret_{setup.seed, core::spread(setup.seed)},
      fleet_(setup.self),
      scratch_(std::make_unique<std::byte[]>(kTrainBytesMax + kDatagramMax)) {
  dds_budget_.set(kDdsWaysPerSecond, kDdsWaysPerSecond);
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
    turns_.emplace_back();
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
  turns_[slot] = {};
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
  now_ = now;
  const auto datagram = decode(bytes);
  if (!datagram) {
    ++counters_.strange;
    return;
  }
  if (const auto* data = std::get_if<Data>(&*datagram)) return on_data(now, from, *data);
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

core::Outcome Links::deliver(Time now, std::uint32_t token, const core::Message& message) {
  Link& link = *links_[token];
  touch(link);
  return link.send(now, message);
}

void Links::reply(Time now, std::uint32_t token, const Header& header) {
  std::array<std::byte, kHeaderSize> bytes{};
  wire::encode_header(header, bytes);
  const core::Outcome outcome = deliver(now, token, {.header = header, .bytes = bytes});
  if (!core::taken(outcome)) lost(links_[token]->client(), header, outcome);
}

// --- time

void Links::on_timeout(Time now) {
  now_ = now;
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
    if (turns_[wake.slot].at <= now) look_for(now, *link);
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

void Links::tell(Time now) {
  // Nobody is told while nothing has changed, and those below never are.
  const std::uint32_t number = router_.below().number();
  const bool news = std::exchange(told_, number) != number;
  const auto tell_one = [&](Link& link) {
    if (link.is_up() && link.settings().kind != LinkKind::kSub) link.tell(now);
  };
  if (!news) {
    for (Link* link : touched_) tell_one(*link);
    return;
  }
  for (const auto& link : links_) {
    if (!link || !link->is_up() || link->settings().kind == LinkKind::kSub) continue;
    link->tell(now);
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

bool Links::send_train(const Train& train, const Send& send) {
  if (send(train)) return true;
  held_ = train;
  return false;
}

bool Links::send_trains(Time now, Link& link, const Send& send) {
  for (std::size_t n = 0; n < kTrainsPerTurn; ++n) {
    Train train{.to = link.address()};
    std::size_t size = 0;
    std::size_t count = 0;
    const std::span all(scratch_.get(), kTrainBytesMax + kDatagramMax);
    for (;;) {
      const std::size_t room = count == 0 ? kDatagramMax : train.datagram_size;
      const std::size_t one = link.build(now, all.subspan(size, room));
      if (one == 0) break;
      if (count == 0) {
        train.datagram_size = one;
        train.dscp = kDscp[link.session().last_lane()];
      }
      size += one;
      ++count;
      // A train's datagrams are of one size but the last. One that is not full is the last, or
      // something else begins behind it.
      const bool full = one == link.session().datagram_size() && one == train.datagram_size;
      if (!full || count == kTrainDatagramsMax || size + one > kTrainBytesMax) break;
    }
    if (count == 0) return true;
    train.bytes = all.first(size);
    if (!send_train(train, send)) return false;
  }
  return false;
}

void Links::flush(Time now, const Send& send) {
  now_ = now;
  choose_uplink(now);
  tell(now);
  report_losses(now);
  if (held_.to && !send(held_)) return;
  held_ = {};
  for (const Single& single : singles_) {
    // One that the socket does not take is lost, as it might be on its way.
    (void)send({.to = single.to,
                .bytes = std::span(single.bytes).first(single.size),
                .datagram_size = single.size,
                .dscp = kDscp[kControlLane]});
  }
  singles_.clear();
  std::erase_if(touched_, [&](Link* link) { return !held_.to && flush_link(now, *link, send); });
}

// False: it has more to send.
bool Links::flush_link(Time now, Link& link, const Send& send) {
  if (!send_trains(now, link, send)) return false;
  std::span probe(scratch_.get(), kDatagramMax);
  const std::size_t size = link.build_probe(now, probe);
  if (size > 0)
    (void)send({.to = link.address(), .bytes = probe.first(size), .datagram_size = size});
  if (were_up_[link.slot()] != link.is_up()) look_anew(now, link);
  is_touched_[link.slot()] = false;
  learn_token(link);
  const Time at = std::min(turns_[link.slot()].at, link.next_timeout(now));
  if (at < wakes_at_[link.slot()]) {
    wakes_at_[link.slot()] = at;
    wake_.push({at, link.slot()});
  }
  return true;
}

void Links::say_goodbye(Time now) {
  for (const auto& link : links_) {
    if (link) link->say_goodbye(now, core::CloseReason::kShutdown);
  }
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

bool Links::by_hand(Time now, std::string_view name, Hand what) {
  Link* link = find(name);
  if (link == nullptr) return false;
  switch (what) {
    case Hand::kUp:
      link->bring_up(now);
      break;
    case Hand::kDown:
      link->take_down(now);
      break;
    case Hand::kReset:
      link->start_anew(now);
      break;
  }
  touch(*link);
  return true;
}

}  // namespace tims::link

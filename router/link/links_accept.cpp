// Links, the part that lets other routers connect.
#include <algorithm>

#include "router/link/links.h"

namespace tims::link {
namespace {

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

}  // namespace

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
                           .peer = std::string_view(from.to_string())},
                .owner = {.id = link.client(),
                          .port = core::PortKind::kLink,
                          .name = core::Text<31>(link.peer().name.view()),
                          .peer = std::string_view(link.address().to_string())}});
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
                           .peer = std::string_view(from.to_string())},
                .text = refuse.text});
}

Link* Links::link_to(const Identity& who) {
  for (const auto& link : links_) {
    if (link && link->is_to(who)) return link.get();
  }
  return nullptr;
}

}  // namespace tims::link

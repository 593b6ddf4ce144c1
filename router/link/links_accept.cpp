// Links, the part that lets other routers connect.
#include <algorithm>

#include "router/link/links.h"

namespace tims::link {
namespace {

constexpr Duration kPendingFor = std::chrono::seconds(3);
constexpr std::size_t kPendingMax = 4096;
// Two routers with one name: how long the first is given to show that it lives, in keep-alives.
constexpr int kRivalKeepAlives = 2;
constexpr Duration kRivalForgotten = std::chrono::seconds(10);

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
    return this->refuse(from, hello, refuse);
  }
  const LinkSettings* settings = accepting(from, hello, refuse);
  // Over DDS, whom a link calls is known by its announcement, which may come after its HELLO.
  const bool may_be_called =
      refuse.code == RefuseCode::kNotConfigured && from.kind == PathKind::kDds;
  if (settings == nullptr && may_be_called && !fleet_.routers().contains(from)) return;
  if (settings == nullptr) {
    note_refused(now, from, hello, refuse);
    return this->refuse(from, hello, refuse);
  }
  // Both call each other: the lower address's call counts.
  if (settings->connects && setup_.self.address() < hello.who.address()) return;
  Link* link = link_to(hello.who);
  if (link == nullptr && settings->connects) link = find(settings->to);
  if (link != nullptr && link->state() == Link::State::kDown) {
    const std::string text = text_of(setup_.self) + " has taken this link down by hand";
    refuse.code = RefuseCode::kNotConfigured;
    refuse.text = std::string_view(text);
    return this->refuse(from, hello, refuse);
  }
  if (link != nullptr && link->peer().epoch != 0) {
    if (link->peer().epoch == hello.who.epoch && hello.resume != 0 &&
        hello.resume == link->our_token() && hello.token == link->their_token()) {
      link->resume(hello);
      std::array<std::byte, kControlDatagramMax> bytes{};
      const Welcome welcome{.resumed = true,
                            .echo = hello.token,
                            .token = link->our_token(),
                            .keep_alive = settings->keep_alive,
                            .who = setup_.self};
      return send(from, std::span(bytes).first(encode(welcome, bytes)));
    }
    switch (rival(now, from, hello, *link, refuse)) {
      case Rival::kNone:
        break;
      case Rival::kWait:
        return;
      case Rival::kRefuse:
        return this->refuse(from, hello, refuse);
    }
  }
  if (link == nullptr && links_in_use() >= setup_.links_max) {
    const std::string text = text_of(setup_.self) + " has as many links as it can hold: " +
                             std::to_string(setup_.links_max);
    refuse.code = RefuseCode::kTooMany;
    refuse.text = std::string_view(text);
    note_refused(now, from, hello, refuse);
    return this->refuse(from, hello, refuse);
  }
  welcome(now, from, hello, *settings);
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
  const bool same_place = link.paths().is_at(from) || hello.who.epoch == link.peer().epoch;
  if (same_place || !link.is_up()) {
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

void Links::welcome(Time now, const NetAddress& from, const Hello& hello,
                    const LinkSettings& settings) {
  std::uint64_t token = 0;
  for (const auto& [ours, pending] : pending_) {
    if (pending.from == from && pending.hello.token == hello.token) token = ours;
  }
  if (token == 0) {
    if (pending_.size() >= kPendingMax) return;
    token = random() | 1;
    pending_[token] = {.hello = hello, .from = from, .settings = &settings, .since = now};
  }
  std::array<std::byte, kControlDatagramMax> bytes{};
  const Welcome welcome{
      .echo = hello.token, .token = token, .keep_alive = settings.keep_alive, .who = setup_.self};
  send(from, std::span(bytes).first(encode(welcome, bytes)));
}

void Links::refuse(const NetAddress& to, const Hello&, Refuse& refuse) {
  ++counters_.refused;
  std::array<std::byte, kControlDatagramMax> bytes{};
  send(to, std::span(bytes).first(encode(refuse, bytes)));
}

void Links::note_refused(Time now, const NetAddress& from, const Hello& hello,
                         const Refuse& refuse) {
  const auto [place, first] = conflicts_.try_emplace(hello.who.address().raw(), now);
  if (!first && now < place->second + kRivalForgotten) return;
  place->second = now;
  router_.note({.at = now,
                .kind = core::EventKind::kLinkRefused,
                .address = hello.who.address(),
                .client = {.id = {},
                           .port = core::PortKind::kLink,
                           .name = core::Text<31>(hello.who.name.view()),
                           .peer = std::string_view(from.to_string())},
                .text = refuse.text});
}

// The answer to a HELLO has arrived: now, and not before, something changes here.
void Links::confirm(Time now, const NetAddress& from, const Data& data, std::uint64_t token) {
  const Pending pending = pending_.extract(token).mapped();
  Link* link = link_to(pending.hello.who);
  if (link == nullptr && pending.settings->connects) link = find(pending.settings->to);
  if (link == nullptr && links_in_use() >= setup_.links_max) return;
  if (link == nullptr) link = &add(*pending.settings);
  tokens_.erase(link->our_token());
  conflicts_.erase(pending.hello.who.address().raw());
  link->accept(now, from, pending.hello, token);
  learn_token(*link);
  link->on_data(now, from, data);
  touch(*link);
}

Link* Links::link_to(const Identity& who) {
  for (const auto& link : links_) {
    if (link && link->is_to(who)) return link.get();
  }
  return nullptr;
}

void Links::drop_old_pending(Time now) {
  std::erase_if(pending_, [&](const auto& p) { return now > p.second.since + kPendingFor; });
}

}  // namespace tims::link

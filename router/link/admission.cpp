#include "router/link/admission.h"

#include <algorithm>
#include <array>
#include <string>

namespace tims::link {
namespace {

// A cookie is valid in the period in which it was made and in the next one.
constexpr Duration kCookiePeriod = std::chrono::seconds(5);
// Two routers with one address: how many keep-alives the first has to prove that it is running.
constexpr int kRivalKeepAlives = 2;
constexpr Duration kRivalForgotten = std::chrono::seconds(10);
// A router that is refused repeatedly is logged at this interval, and only a limited number of
// routers at a time.
constexpr Duration kRefusedAgain = std::chrono::seconds(10);
constexpr std::size_t kRefusedMax = 64;

constexpr std::string_view kPlainNotWanted =
    " links only with routers that have keys: timsctl join on the other host, or secure = false in "
    "the [[link]] of both";
constexpr std::string_view kSealedNotWanted =
    " has secure = false in this [[link]]: both sides must say so";

constexpr std::string_view kIdTwice =
    " is running with this system and id: choose another [router] id";
// With keys, the certificate says so as well: most likely the disk was copied with the keys on it.
constexpr std::string_view kCertificateTwice =
    " is running with this certificate: a copied disk? timsctl token new at the base, and timsctl "
    "join";

std::string text_of(const Identity& identity) {
  return identity.address().to_string(identity.widths) + " " + std::string(identity.name.view());
}

// True when the roles allow this kind of link.
bool fits(LinkKind kind, Role lower, Role upper) {
  if (kind == LinkKind::kPeer) return lower == upper && lower != Role::kSubsystem;
  return (lower == Role::kSubsystem && upper == Role::kSystem) ||
         (lower == Role::kSystem && upper == Role::kTop);
}

std::string systems_text(std::span<const LinkSettings> settings) {
  std::string text;
  for (const LinkSettings& s : settings) {
    if (s.connects) continue;
    text += (text.empty() ? "" : ", ") + (s.system ? std::to_string(*s.system) : std::string("*"));
  }
  return text;
}

}  // namespace

std::optional<Refuse> Admission::version_refusal(const Hello& hello) {
  if (hello.version_min <= kVersionMax && hello.version_max >= kVersionMin) return std::nullopt;
  const std::string text =
      "this router supports version " + std::to_string(kVersionMin) + " to " +
      std::to_string(kVersionMax) + " of the protocol, the other router supports " +
      std::to_string(hello.version_min) + " to " + std::to_string(hello.version_max);
  return Refuse{.echo = hello.token, .text = std::string_view(text)};
}

Refuse Admission::refusal(const Hello& hello, RefuseCode code, std::string_view what) const {
  const std::string text = text_of(self_) + std::string(what);
  return {.echo = hello.token, .code = code, .text = std::string_view(text)};
}

// --- verification of addresses

// As in DTLS (RFC 9147, section 5.1): computed from the contents of the HELLO, so that no state
// is needed.
std::uint64_t Admission::cookie(const NetAddress& from, std::uint64_t token, std::uint64_t epoch,
                                Duration period) const {
  std::array<std::uint64_t, 2> ip{};
  for (std::size_t i = 0; i < from.ip.size(); ++i) ip[i / 8] = ip[i / 8] << 8 | from.ip[i];
  const std::uint64_t place = std::uint64_t{from.scope} << 32 | std::uint64_t{from.port} << 8 |
                              static_cast<std::size_t>(from.kind);
  const auto number = static_cast<std::uint64_t>(period / kCookiePeriod);
  return core::sip_hash(secret_, {ip[0], ip[1], place, token, epoch, number});
}

bool Admission::is_proven(Time now, const NetAddress& from, std::uint64_t token,
                          std::uint64_t epoch, std::uint64_t given) const {
  const Duration period = now.time_since_epoch();
  return given == cookie(from, token, epoch, period) ||
         given == cookie(from, token, epoch, period - kCookiePeriod);
}

// The setting under which this router may connect; null otherwise, with the reason in `refuse`.
const LinkSettings* Admission::accepting(std::span<const LinkSettings> settings,
                                         const NetAddress& from, const Hello& hello,
                                         const IsCalled& is_called, Refuse& refuse) const {
  const Identity& self = self_;
  const Identity& identity = hello.identity;
  const auto no = [&](RefuseCode code, const std::string& text) {
    refuse.code = code;
    refuse.text = std::string_view(text);
    return nullptr;
  };
  if (identity.epoch == self.epoch)
    return no(RefuseCode::kDuplicateId, "this is the router itself");
  if (identity.system == self.system && identity.id == self.id)
    return no(RefuseCode::kDuplicateId,
              text_of(self) + " already has this system and id: choose another [router] id");
  if (identity.widths != self.widths)
    return no(RefuseCode::kWidths,
              text_of(self) + " has other address fields: see [address] widths");
  if (identity.classes != self.classes)
    return no(RefuseCode::kClasses, text_of(self) + " has message.classes " +
                                        self.classes.to_string() + ", not " +
                                        identity.classes.to_string());
  const LinkKind ours = hello.kind == LinkKind::kSuper ? LinkKind::kSub : LinkKind::kPeer;
  if (!fits(hello.kind, identity.role, self.role))
    return no(RefuseCode::kRole, text_of(self) + " is a " + std::string(name(self.role)) +
                                     " router, which cannot be a " + std::string(name(hello.kind)) +
                                     " router for a " + std::string(name(identity.role)) +
                                     " router");
  const bool sealed = hello.version_min == kVersionSealed;
  bool otherwise_sealed = false;
  bool any_of_kind = false;
  bool other_path = false;
  for (const LinkSettings& s : settings) {
    if (s.kind != ours) continue;
    if (std::ranges::find(s.paths, from.kind) == s.paths.end()) {
      other_path = true;
      continue;
    }
    if (s.secure != sealed) {
      otherwise_sealed = true;
      continue;
    }
    if (s.connects) {
      if (is_called(s)) return &s;
      continue;
    }
    any_of_kind = true;
    if (!s.system || *s.system == identity.system) return &s;
  }
  if (!any_of_kind && otherwise_sealed)
    return no(RefuseCode::kVersion,
              text_of(self) + std::string(sealed ? kSealedNotWanted : kPlainNotWanted));
  if (!any_of_kind && other_path)
    return no(RefuseCode::kNotConfigured,
              text_of(self) + " accepts no link over " + std::string(name(from.kind)) +
                  ": see paths of its [[link]] with kind = \"" + std::string(name(ours)) + "\"");
  if (!any_of_kind)
    return no(RefuseCode::kNotConfigured,
              text_of(self) + " has no [[link]] with kind = \"" + std::string(name(ours)) + "\"");
  return no(RefuseCode::kSystem, text_of(self) + " accepts system " + systems_text(settings) +
                                     ", not " + std::to_string(identity.system));
}

// A router with this system and id is already linked. Either it has restarted, or there are two
// of them.
Admission::Rival Admission::rival(Time now, const NetAddress& from, const Hello& hello,
                                  const Link& link, Refuse& refuse) {
  const std::uint32_t address = hello.identity.address().raw();
  // Our token proves that the sender is the router it was issued to. An epoch is not a secret.
  const bool same = link.paths().is_at(from) || hello.resume == link.our_token();
  if (same || !link.is_up()) {
    conflicts_.erase(address);
    return Rival::kNone;
  }
  const Duration patience = kRivalKeepAlives * link.their_keep_alive();
  std::erase_if(conflicts_, [&](const auto& c) { return now > c.second + kRivalForgotten; });
  auto [conflict, first] = conflicts_.try_emplace(address, now);
  if (link.last_received() <= conflict->second) {
    return now > conflict->second + patience ? Rival::kNone : Rival::kWait;
  }
  if (!first && now <= conflict->second + patience / 2) return Rival::kWait;
  refuse.code = RefuseCode::kDuplicateId;
  const bool sealed = hello.version_min == kVersionSealed;
  refuse.text = std::string_view(text_of(link.peer()) + " at " + link.address().to_string() +
                                 std::string(sealed ? kCertificateTwice : kIdTwice));
  if (may_note(now, from))
    router_.note(
        {.at = now,
         .kind = core::EventKind::kDuplicateRouter,
         .address = hello.identity.address(),
         .client = link_peer(hello.identity.name.view(), from.to_string()),
         .owner = link_peer(link.peer().name.view(), link.address().to_string(), link.client())});
  return Rival::kRefuse;
}

bool Admission::may_note(Time now, const NetAddress& from) {
  std::erase_if(noted_, [&](const auto& r) { return now >= r.second + kRefusedAgain; });
  return noted_.size() < kRefusedMax && noted_.try_emplace(from, now).second;
}

void Admission::note_refused(Time now, const NetAddress& from, const Identity& who,
                             std::string_view why) {
  if (!may_note(now, from)) return;
  router_.note({.at = now,
                .kind = core::EventKind::kLinkRefused,
                .address = who.epoch == 0 ? Address() : who.address(),
                .client = link_peer(who.name.view(), from.to_string()),
                .text = why});
}

}  // namespace tims::link

#include "router/link/reception.h"

#include <array>
#include <string>
#include <utility>

namespace tims::link {
namespace {

// A REFUSE is the longest answer that a stranger can get.
constexpr std::uint64_t kRefusalsPerSecond = 20;

Verified taken_from(Handshakes::One* handshake) {
  return handshake == nullptr ? Verified{} : std::move(handshake->verified);
}

}  // namespace

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

Reception::Reception(core::Router& router, House& house, const Setup& setup)
    : house_(house),
      setup_(setup),
      admission_(router, setup.self, setup.secret),
      handshakes_(setup.handshaker, *this),
      refusals_(kRefusalsPerSecond, kRefusalsPerSecond) {}

// --- datagrams

void Reception::on_hello(Time now, const NetAddress& from, const Hello& hello) {
  const Caller caller{from};
  if (const auto refusal = Admission::version_refusal(hello)) return refuse(now, caller, *refusal);
  const Link* link = house_.link_to(hello.identity);
  const bool resumes = link != nullptr && !link->settings().secure && link->is_of_session(hello);
  const std::uint64_t epoch = hello.identity.epoch;
  // Nothing is stored, looked up or sent at length for an unverified address.
  if (!resumes && !admission_.is_proven(now, from, hello.token, epoch, hello.cookie))
    return ask_for_cookie(now, from, hello.token, epoch);
  admit(now, caller, hello);
}

void Reception::on_hello(Time now, const NetAddress& from, const SealedHello& hello) {
  if (const auto cookie = handshakes_.cookie_of(from, hello.token))
    return answer(now, {from}, Retry{hello.token, *cookie});
  ask_for_cookie(now, from, hello.token, 0);
}

void Reception::on_crypto(Time now, const NetAddress& from, const Crypto& crypto) {
  if (handshakes_.on_crypto(now, from, crypto) || crypto.from_accepting || crypto.offset != 0)
    return;
  if (!admission_.is_proven(now, from, crypto.token, 0, crypto.cookie)) return;
  if (has_keys()) {
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

// --- handshakes

void Reception::on_message(Time now, Handshakes::One& handshake) {
  // The other side sends one message; what it has proven is used once.
  if (handshake.answered || handshake.verified.sealer == nullptr) return;
  if (!is_believed(now, handshake)) return;
  if (handshake.side == Handshaker::Side::kAccepts) return on_who(now, handshake);
  if (const auto datagram = decode(handshake.message)) {
    const auto* welcome = std::get_if<Welcome>(&*datagram);
    if (welcome != nullptr && welcome->echo == handshake.token)
      house_.on_welcome(now, handshake.address, *welcome, &handshake);
    const auto* refuse = std::get_if<Refuse>(&*datagram);
    if (refuse != nullptr && refuse->echo == handshake.token)
      house_.on_refuse(now, handshake.address, *refuse);
  }
  handshakes_.finish(now, handshake);
}

// The handshake may have begun before the newest list was in force.
bool Reception::is_believed(Time now, Handshakes::One& handshake) {
  const Standing standing = house_.standing(handshake.verified.peer);
  if (standing == Standing::kGood) return true;
  const Refuse refusal{.echo = handshake.token,
                       .code = RefuseCode::kCertificate,
                       .text = core::sentence(close_reason(standing))};
  if (handshake.side == Handshaker::Side::kConnects) {
    house_.on_refuse(now, handshake.address, refusal);
    handshakes_.finish(now, handshake);
  } else {
    admission_.note_refused(now, handshake.address, {}, refusal.text.view());
    refuse(now, {handshake.address, &handshake}, refusal);
  }
  return false;
}

void Reception::on_who(Time now, Handshakes::One& handshake) {
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
void Reception::on_failed(Time now, const Handshakes::One& handshake, std::string_view why) {
  const Refuse refusal{.echo = handshake.token, .code = RefuseCode::kCertificate, .text = why};
  if (handshake.side == Handshaker::Side::kConnects)
    return house_.on_refuse(now, handshake.address, refusal);
  admission_.note_refused(now, handshake.address, {}, why);
  refuse(now, {handshake.address}, refusal);
}

// --- admission

void Reception::admit(Time now, const Caller& caller, const Hello& hello) {
  Link* link = house_.link_to(hello.identity);
  const LinkSettings* settings = settings_for(now, caller, hello, link);
  if (settings == nullptr) return;
  // Both sides connect to each other: the call of the lower address is used.
  if (settings->connects && setup_.self.address() < hello.identity.address()) return;
  if (link != nullptr && link->is_of_session(hello)) return resume(now, caller, hello, *link);
  if (link == nullptr && settings->connects) link = house_.find(settings->to);
  if (link != nullptr) {
    Refuse refusal{.echo = hello.token};
    const Verdict verdict = judge(now, caller, hello, *link, refusal);
    if (verdict == Verdict::kRefuse) refuse(now, caller, refusal);
    if (verdict == Verdict::kTake) take(now, caller, hello, *link);
    return;
  }
  if (house_.links_in_use() < setup_.links_max)
    return take(now, caller, hello, house_.add(now, *settings));
  const Refuse full =
      admission_.refusal(hello, RefuseCode::kTooMany,
                         " has as many links as it can hold: " + std::to_string(setup_.links_max));
  admission_.note_refused(now, caller.address, hello.identity, full.text.view());
  refuse(now, caller, full);
}

// Null: the caller was refused, or has to come again.
const LinkSettings* Reception::settings_for(Time now, const Caller& caller, const Hello& hello,
                                            const Link* link) {
  const NetAddress& from = caller.address;
  Refuse refusal{.echo = hello.token};
  // Both sides connect: accept a router that is at an address we connect to, or that we were
  // linked with.
  const LinkSettings* settings = admission_.accepting(
      house_.settings(), from, hello,
      [&](const LinkSettings& s) { return house_.calls(s, from, hello.identity); }, refusal);
  // Over DDS, the router a link connects to is known by its announcement, which may arrive after
  // its HELLO.
  const bool may_be_called =
      refusal.code == RefuseCode::kNotConfigured && from.kind == PathKind::kDds;
  if (settings == nullptr && may_be_called && !house_.is_announced(from)) return nullptr;
  // A session with keys goes on with keys, or ends first, however long it has been silent.
  if (settings != nullptr && (link == nullptr || link->settings().secure == settings->secure))
    return settings;
  if (settings != nullptr)
    refusal = admission_.refusal(hello, RefuseCode::kDuplicateId,
                                 settings->secure ? " is linked with this router without keys"
                                                  : " is linked with this router with keys");
  admission_.note_refused(now, from, hello.identity, refusal.text.view());
  refuse(now, caller, refusal);
  return nullptr;
}

// Whether the caller may take this link over. `refusal`: why not.
Reception::Verdict Reception::judge(Time now, const Caller& caller, const Hello& hello,
                                    const Link& link, Refuse& refusal) {
  if (link.state() == Link::State::kDown) {
    refusal =
        admission_.refusal(hello, RefuseCode::kNotConfigured, " has taken this link down manually");
    return Verdict::kRefuse;
  }
  if (link.peer().epoch == 0) return Verdict::kTake;
  switch (admission_.rival(now, caller.address, hello, link, refusal)) {
    case Admission::Rival::kNone:
      break;
    case Admission::Rival::kWait:
      // A HELLO comes again by itself.
      if (caller.handshake != nullptr)
        Handshakes::ask_again(now, *caller.handshake, hello.keep_alive);
      return Verdict::kWait;
    case Admission::Rival::kRefuse:
      return Verdict::kRefuse;
  }
  return Verdict::kTake;
}

void Reception::take(Time now, const Caller& caller, const Hello& hello, Link& link) {
  admission_.forget_rivals(hello.identity);
  if (!link.accept(now, caller.address, hello, house_.random() | 1, taken_from(caller.handshake)))
    return;
  house_.was_taken(link);
  welcome(now, caller, hello, link, std::nullopt);
}

void Reception::resume(Time now, const Caller& caller, const Hello& hello, Link& link) {
  const std::uint8_t generation =
      link.resume(now, caller.address, hello, taken_from(caller.handshake));
  house_.was_taken(link);
  welcome(now, caller, hello, link, generation);
}

// `resumed`: the generation of the keys with which a session continues.
void Reception::welcome(Time now, const Caller& caller, const Hello& hello, const Link& link,
                        std::optional<std::uint8_t> resumed) {
  answer(now, caller,
         Welcome{.version = caller.handshake != nullptr ? kVersionSealed : kVersionPlain,
                 .resumed = resumed.has_value(),
                 .generation = resumed.value_or(0),
                 .echo = hello.token,
                 .token = link.our_token(),
                 .keep_alive = link.settings().keep_alive,
                 .identity = setup_.self,
                 .codecs = kCodecs});
}

void Reception::ask_for_cookie(Time now, const NetAddress& from, std::uint64_t token,
                               std::uint64_t epoch) {
  if (retries_.try_take(now)) return answer(now, {from}, admission_.retry(now, from, token, epoch));
  ++refused_;
}

void Reception::refuse(Time now, const Caller& caller, const Refuse& refusal) {
  ++refused_;
  if (caller.handshake != nullptr || refusals_.try_take(now)) answer(now, caller, refusal);
}

template <typename Datagram>
void Reception::answer(Time now, const Caller& caller, const Datagram& datagram) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const auto encoded = std::span(bytes).first(encode(datagram, bytes));
  caller.handshake != nullptr ? handshakes_.answer(now, *caller.handshake, encoded)
                              : send(caller.address, encoded);
}

}  // namespace tims::link

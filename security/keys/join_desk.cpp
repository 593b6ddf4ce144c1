#include "security/keys/join_desk.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"
#include "security/keys/bytes.h"

namespace tims::security {
namespace {

constexpr int kGuessesMax = 5;
constexpr std::int64_t kGuessTime = 60;
constexpr std::size_t kSourcesMax = 1024;

JoinAnswer refusal(std::string why) {
  return {.refused = std::move(why), .chain = {}, .roots = {}, .list = {}};
}

void append_field(Bytes& out, std::string_view text) {
  append_counted<std::uint16_t>(out, view_of(text));
}

std::string_view field(Reader& reader) { return text_of(reader.counted<std::uint16_t>()); }

std::string age(std::int64_t seconds) {
  if (seconds < 120) return fmt::format("{} s", seconds);
  return seconds < 7200 ? fmt::format("{} min", seconds / 60) : fmt::format("{} h", seconds / 3600);
}

std::string another_token(const Identity& identity) {
  if (identity.role == MemberRole::kUser)
    return fmt::format("make a new one on the base: timsctl token new --role user --name {}",
                       identity.name);
  return fmt::format("make a new one on the base: timsctl token new --role {} --system {} --id {}",
                     name(identity.role), identity.system, identity.id);
}

}  // namespace

Bytes JoinRequest::encode() const {
  Bytes out;
  append_field(out, renews ? "renew1" : "join1");
  if (!renews) {
    append_field(out, token);
    append_counted<std::uint16_t>(out, proof);
  }
  append_field(out, pem);
  return out;
}

Result<JoinRequest> JoinRequest::parse(View bytes) {
  Reader reader(bytes);
  JoinRequest request;
  const std::string_view kind = field(reader);
  request.renews = kind == "renew1";
  if (!request.renews && kind != "join1")
    return Error(Errc::kVersion, "neither join1 nor renew1: another version of timsctl");
  if (!request.renews) {
    request.token = field(reader);
    const View proof = reader.counted<std::uint16_t>();
    if (proof.size() != request.proof.size())
      return Error(Errc::kMalformed, "the proof of a token has 32 bytes");
    std::ranges::copy(proof, request.proof.begin());
  }
  request.pem = field(reader);
  if (!reader.ok() || !reader.left().empty()) return Error(Errc::kMalformed, "not a request");
  return request;
}

Bytes JoinAnswer::encode() const {
  Bytes out;
  append_field(out, refused.empty() ? "ok" : "no");
  if (!refused.empty()) {
    append_field(out, refused);
    return out;
  }
  append_field(out, chain);
  append_field(out, roots);
  append(out, list);
  return out;
}

Result<JoinAnswer> JoinAnswer::parse(View bytes) {
  Reader reader(bytes);
  JoinAnswer answer;
  const std::string_view kind = field(reader);
  if (kind == "no") {
    answer.refused = base::printable_lines(field(reader));
    if (answer.refused.empty()) answer.refused = "no reason";
  } else if (kind == "ok") {
    answer.chain = field(reader);
    answer.roots = field(reader);
    answer.list.assign(reader.left().begin(), reader.left().end());
  } else {
    return Error(Errc::kMalformed, "not an answer of an authority");
  }
  if (!reader.ok()) return Error(Errc::kMalformed, "half an answer of an authority");
  return answer;
}

void GuessLimit::forget_old(std::int64_t now) {
  std::erase_if(guesses_, [&](const auto& one) { return now - one.second.since > kGuessTime; });
}

bool GuessLimit::allows(const std::string& source, std::int64_t now) {
  forget_old(now);
  const auto found = guesses_.find(source);
  if (found != guesses_.end()) return found->second.count < kGuessesMax;
  return guesses_.size() < kSourcesMax || now - others_.since > kGuessTime ||
         others_.count < kGuessesMax;
}

void GuessLimit::count(const std::string& source, std::int64_t now) {
  forget_old(now);
  const bool known = guesses_.contains(source) || guesses_.size() < kSourcesMax;
  Guesses& guesses = known ? guesses_[source] : others_;
  if (guesses.count == 0 || now - guesses.since > kGuessTime) guesses = {.since = now, .count = 0};
  ++guesses.count;
}

JoinAnswer JoinDesk::answer(const JoinRequest& request, const Asker& asker, std::int64_t now) {
  // One change of the authority after the other.
  const auto lock = keys_.lock();
  if (!lock) return refusal("the base: " + lock.error().detail());
  const auto authority = Authority::open(keys_);
  if (!authority) return refusal("the base: " + authority.error().detail());
  return request.renews ? renew(*authority, request, asker, now)
                        : join(*authority, request, asker, now);
}

JoinAnswer JoinDesk::join(const Authority& authority, const JoinRequest& request,
                          const Asker& asker, std::int64_t now) {
  if (!guesses_.allows(asker.source, now))
    return refusal("more than five wrong tokens from this address: wait a minute");
  const Tokens tokens(authority);
  auto token = tokens.find(request.token);
  if (!token || !equal_secretly(join_proof(token->hash, asker.keys), request.proof)) {
    guesses_.count(asker.source, now);
    return refusal(
        fmt::format("no token {}: it was revoked, or is of another base; timsctl token "
                    "list on the base shows all",
                    base::printable(request.token)));
  }
  if (now > token->ends)
    return refusal(fmt::format("token {} is {} old and has ended: {}", token->id(),
                               age(now - token->made), another_token(token->identity)));
  const auto csr = CertificateRequest::from_pem(request.pem);
  if (!csr) return refusal(csr.error().detail());
  const Digest key = csr->public_key_hash();
  if (token->used_by && *token->used_by != key)
    return refusal(
        fmt::format("token {} was used already: {}", token->id(), another_token(token->identity)));
  if (!csr->uris().empty() && csr->uris() != token->identity.uris())
    return refusal(fmt::format("token {} is for {}, not for {}", token->id(),
                               token->identity.to_string(), base::printable(csr->uris().front())));
  if (!token->used_by) {
    token->used_by = key;  // first: a token that cannot be marked is not used
    if (auto done = tokens.store(*token); !done)
      return refusal("the base: " + done.error().detail());
  }
  return issue(authority, token->identity, *csr, asker, now);
}

JoinAnswer JoinDesk::renew(const Authority& authority, const JoinRequest& request,
                           const Asker& asker, std::int64_t now) {
  if (!asker.proven) return refusal("who renews must show its present certificate");
  const auto identity = identity_of(*asker.proven, authority.fleet());
  if (!identity) return refusal(identity.error().detail());
  const auto list = authority.list();
  if (!list) return refusal("the base: " + list.error().detail());
  if (list->revokes(*asker.proven)) return refusal("this certificate is revoked: join again");
  const auto csr = CertificateRequest::from_pem(request.pem);
  if (!csr) return refusal(csr.error().detail());
  if (!csr->uris().empty() && csr->uris() != identity->uris())
    return refusal("a renewed certificate has the names of the present one");
  return issue(authority, *identity, *csr, asker, now);
}

// The same key gets the same certificate again: the answer may have been lost.
JoinAnswer JoinDesk::issue(const Authority& authority, const Identity& identity,
                           const CertificateRequest& request, const Asker& asker,
                           std::int64_t now) {
  const auto list = authority.list();
  const auto list_bytes = authority.list_bytes();
  if (!list || !list_bytes)
    return refusal("the base: " + (list ? list_bytes.error() : list.error()).detail());
  JoinAnswer answer;
  answer.roots = to_pem(list->roots);
  answer.list = *list_bytes;
  const auto present = authority.issued_for(request.public_key_hash());
  if (present && present->uris() == identity.uris()) {
    answer.chain = to_pem(authority.chain_of(*present));
    return answer;
  }
  // Browsers reach it at the address that it has asked from. A name it could choose itself.
  const auto chain = authority.issue(identity, {asker.source}, request, now);
  if (!chain) return refusal("the base: " + chain.error().detail());
  answer.chain = to_pem(*chain);
  return answer;
}

namespace {

// Of who enters a fleet: the chain must lead to a root of the list, which the expected root, if one
// is given, must be among.
Result<void> enter(const KeyFolder& keys, const JoinAnswer& answer,
                   const std::vector<Certificate>& chain, const std::string& fleet,
                   const Expected& expected) {
  const auto roots = Certificate::from_pem(answer.roots);
  if (!roots) return roots.error();
  const auto list = FleetList::open(answer.list, *roots, fleet);
  if (!list) return list.error();
  const bool has_root =
      !expected.root || std::ranges::any_of(list->roots, [&](const Certificate& one) {
        return std::ranges::equal(View(one.fingerprint()).first(expected.root->size()),
                                  *expected.root);
      });
  if (!has_root || !leads_to(list->roots, chain))
    return Error(Errc::kRefused, "the certificate does not come from the expected authority");
  return keys.take_over(chain, list->roots, answer.list);
}

}  // namespace

Result<Identity> take_over(const KeyFolder& keys, const JoinAnswer& answer,
                           const Expected& expected) {
  if (!answer.refused.empty()) return Error(Errc::kRefused, answer.refused);
  const auto chain = Certificate::from_pem(answer.chain);
  if (!chain) return chain.error();
  auto identity = Identity::parse(chain->front().uris());
  if (!identity) return identity.error();
  if (expected.identity && *identity != *expected.identity)
    return Error(Errc::kRefused, "the certificate is that of " + identity->to_string() +
                                     ", not of " + expected.identity->to_string());
  const auto key = keys.next_key();
  if (!key) return key.error();
  if (!chain->front().belongs_to(*key))
    return Error(Errc::kMalformed, "the certificate is for another key than the one in " +
                                       keys.file("identity.key.next"));
  const bool is_member = expected.identity || (!expected.another_fleet && keys.load().ok());
  const auto done = is_member ? keys.renew(*chain, answer.list)
                              : enter(keys, answer, *chain, identity->fleet, expected);
  if (!done) return done.error();
  return identity;
}

}  // namespace tims::security

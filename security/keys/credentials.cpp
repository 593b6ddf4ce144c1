#include "security/keys/credentials.h"

#include <algorithm>

#include "base/text.h"

namespace tims::security {
namespace {

// 2026-01-01. No program of this project is older than its list of what has passed.
constexpr std::int64_t kEpochOfProject = 1767225600;

// Whom a robot needs in order to go on, whatever its list says of others.
bool is_of_own_robot_or_above(const Identity& own, const Identity& other) {
  if (own.role == MemberRole::kTop || own.role == MemberRole::kUser) return false;
  if (other.role == MemberRole::kTop) return true;
  return other.role != MemberRole::kUser && other.system == own.system;
}

std::string described(const Certificate& certificate) {
  const auto identity = Identity::parse(certificate.uris());
  return identity ? identity->to_string() : "\"" + base::printable(certificate.subject()) + "\"";
}

}  // namespace

std::int64_t Credentials::passed() const {
  std::int64_t newest = kEpochOfProject;
  for (const Certificate& one : chain) newest = std::max(newest, one.not_before());
  for (const Certificate& one : roots) newest = std::max(newest, one.not_before());
  return list ? std::max(newest, list->made) : newest;
}

Result<Identity> identity_of(const Certificate& certificate, std::string_view fleet) {
  auto identity = Identity::parse(certificate.uris());
  if (identity && identity->fleet != fleet)
    return Error(Errc::kMalformed,
                 "is of the fleet \"" + identity->fleet + "\", not \"" + std::string(fleet) + "\"");
  return identity;
}

bool leads_to(const std::vector<Certificate>& roots, const std::vector<Certificate>& chain) {
  return chain.size() == 2 && chain.back().is_authority() &&
         chain.back().has_signed(chain.front()) &&
         std::ranges::any_of(
             roots, [&](const Certificate& root) { return root.has_signed(chain.back()); });
}

bool BelievedRoots::have_signed(const Bytes& issuing) {
  const auto [known, is_new] = known_.try_emplace(issuing, false);
  if (!is_new) return known->second;
  if (const auto certificate = Certificate::from_der(issuing))
    known->second = std::ranges::any_of(
        roots_, [&](const Certificate& root) { return root.has_signed(*certificate); });
  return known->second;
}

std::string_view state_of(const Credentials& own, const CheckTime& time) {
  const Certificate& certificate = own.chain.front();
  if (own.list && own.list->revokes(certificate)) return "revoked";
  switch (validity(time, certificate.not_before(), certificate.not_after())) {
    case Validity::kExpired:
      return "expired";
    case Validity::kEnding:
      return "ends soon";
    case Validity::kNotYet:
      return "not valid yet";
    case Validity::kUnchecked:
      return "valid, but the clock is not synchronised";
    case Validity::kValid:
      break;
  }
  return is_renewal_due(time, certificate.not_before(), certificate.not_after())
             ? "valid, due to be renewed"
             : "valid";
}

// The newest root of a list is its last one.
bool has_old_root(const Credentials& own) {
  return own.roots.size() > 1 && !own.roots.back().has_signed(own.chain.back());
}

bool is_list_old(const FleetList* list, const CheckTime& time, std::int64_t list_age_max) {
  if (!time.trusted || list_age_max == 0) return false;
  return list == nullptr || time.now - list->made > list_age_max;
}

std::optional<Refusal> judge(const Certificate& certificate, int depth, const Identity& own,
                             const FleetList* list, const CheckTime& time,
                             const Strictness& strictness) {
  const auto refused = [&](Refusal::Code code, std::string_view why) {
    return Refusal{code, "the certificate of " + described(certificate) + " " + std::string(why)};
  };
  if (list != nullptr && list->revokes(certificate))
    return refused(Refusal::Code::kRevoked,
                   "is revoked by list " + std::to_string(list->number) + " of the fleet");
  switch (validity(time, certificate.not_before(), certificate.not_after())) {
    case Validity::kNotYet:
      return refused(Refusal::Code::kNotYetValid, "is not valid yet: compare both clocks");
    case Validity::kExpired:
      if (strictness.expired)
        return refused(Refusal::Code::kExpired,
                       "has expired: run timsctl key renew there (security.refuse_expired)");
      break;
    case Validity::kValid:
    case Validity::kEnding:
    case Validity::kUnchecked:
      break;
  }
  if (depth != 0) return std::nullopt;
  const auto identity = identity_of(certificate, own.fleet);
  if (!identity) return refused(Refusal::Code::kIdentity, identity.error().detail());
  if (strictness.old_list && is_list_old(list, time, strictness.list_age_max) &&
      !is_of_own_robot_or_above(own, *identity))
    return refused(Refusal::Code::kOldList,
                   "may have been revoked: the list of the fleet is older here than "
                   "security.list_age_max (security.refuse_old_list)");
  return std::nullopt;
}

TlsSettings member_settings(const Credentials& own, TlsSettings::Side side,
                            const Strictness& strictness) {
  TlsSettings settings;
  settings.side = side;
  settings.peer = TlsSettings::PeerCertificate::kRequired;
  settings.chain = own.chain;
  settings.key = own.key;
  settings.trusted = own.roots;
  settings.judge = [identity = own.identity, list = own.list, passed = own.passed(), strictness](
                       const Certificate& certificate, int depth) {
    return judge(certificate, depth, identity, list.get(), system_check_time(passed), strictness);
  };
  return settings;
}

TlsSettings client_settings(
    const Credentials& own,
    std::function<std::optional<Refusal>(const Certificate& server)> expects) {
  TlsSettings settings = member_settings(own, TlsSettings::Side::kClient);
  settings.judge = [is_member = settings.judge, expects = std::move(expects)](
                       const Certificate& certificate, int depth) {
    auto refusal = is_member(certificate, depth);
    return refusal || depth != 0 ? refusal : expects(certificate);
  };
  return settings;
}

}  // namespace tims::security

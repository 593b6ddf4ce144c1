// What a member shows to others, and whom it believes.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "security/crypto/tls_context.h"
#include "security/keys/clock_rule.h"
#include "security/keys/fleet_list.h"
#include "security/keys/identity.h"

namespace tims::security {

struct Credentials {
  Identity identity;
  std::vector<Certificate> chain;  // own certificate, then the issuing one
  PrivateKey key;
  std::vector<Certificate> roots;
  std::shared_ptr<const FleetList> list;  // null: none yet
  Bytes list_bytes;                       // the same, as it is passed on

  [[nodiscard]] std::uint64_t list_number() const { return list ? list->number : 0; }
  // ClockFacts::passed: when this program was built, and the dates of what is here.
  [[nodiscard]] std::int64_t passed() const;
};

// The identity in a verified certificate, which must be one of this fleet.
Result<Identity> identity_of(const Certificate& certificate, std::string_view fleet);

// Whether a chain is a member's certificate and an issuing one, and comes from one of the roots.
bool leads_to(const std::vector<Certificate>& roots, const std::vector<Certificate>& chain);

// Whether certificates come from one of the roots that a list believes. Nearly all members have the
// same issuing certificate, so each is looked at once.
class BelievedRoots {
 public:
  explicit BelievedRoots(std::vector<Certificate> roots) : roots_(std::move(roots)) {}
  // `issuing`: DER.
  [[nodiscard]] bool have_signed(const Bytes& issuing);

 private:
  std::vector<Certificate> roots_;
  std::map<Bytes, bool> known_;
};

// What a member refuses, provided that its clock can be trusted. By default nothing: what is past
// its time is reported.
struct Strictness {
  bool expired = false;           // certificates that have expired
  std::int64_t list_age_max = 0;  // seconds, after which a list of the fleet is old; 0: never
  // With an old list, which may not name them yet: users, and routers of other systems that are not
  // above. Those of the own robot and above are accepted: they do not stop, and bring a new list.
  bool old_list = false;
};

// A member that has no list has an old one.
bool is_list_old(const FleetList* list, const CheckTime& time, std::int64_t list_age_max);

// The own certificate as people are told: "valid", "valid, due to be renewed" (from half of its
// life on), "valid, but the clock is not synchronised", "ends soon", "expired", "not valid yet",
// "revoked".
std::string_view state_of(const Credentials& own, const CheckTime& time);

// The root of the fleet is being replaced, and the own certificate comes from an older one: a new
// certificate is to be asked for, by all but the base.
bool has_old_root(const Credentials& own);

// Whether a certificate of a right chain is accepted: not revoked, its dates, and (depth 0) names a
// member of the fleet.
std::optional<Refusal> judge(const Certificate& certificate, int depth, const Identity& own,
                             const FleetList* list, const CheckTime& time,
                             const Strictness& strictness);

// For links and connections between members: TLS 1.3, certificates on both sides.
TlsSettings member_settings(const Credentials& own, TlsSettings::Side side,
                            const Strictness& strictness = {});

// The same for a client that expects more of the other side than to be a member: `expects` is asked
// about its certificate.
TlsSettings client_settings(
    const Credentials& own,
    std::function<std::optional<Refusal>(const Certificate& server)> expects);

}  // namespace tims::security

// What a member shows to others, and whom it believes.
#pragma once

#include <cstdint>
#include <functional>
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

enum class Expiry : std::uint8_t { kWarn, kRefuse };

// The own certificate as people are told: "valid", "valid, due to be renewed" (from half of its
// life on), "valid, but the clock is not synchronised", "ends soon", "expired", "not valid yet",
// "revoked".
std::string_view state_of(const Credentials& own, const CheckTime& time);

// The root of the fleet is being replaced, and the own certificate comes from an older one: a new
// certificate is to be asked for, by all but the base.
bool has_old_root(const Credentials& own);

// Whether a certificate of a right chain is accepted: not revoked, its dates, and (depth 0) names a
// member of the fleet. With kWarn an expired certificate is accepted.
std::optional<Refusal> judge(const Certificate& certificate, int depth, std::string_view fleet,
                             const FleetList* list, const CheckTime& time, Expiry expiry);

// For links and connections between members: TLS 1.3, certificates on both sides.
TlsSettings member_settings(const Credentials& own, TlsSettings::Side side, Expiry expiry);

}  // namespace tims::security

// What timsctl key, token and join have in common.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "security/keys/authority.h"
#include "tools/cli/context.h"

namespace timsctl {

namespace security = tims::security;

// --keys, else $TIMS_KEYS, else /etc/tims/keys.
security::KeyFolder key_folder(const Options& options);

// The identity that --role, --system, --id, --name and --rights describe. Throws Failure if they do
// not fit together.
security::Identity identity_of(const Options& options, const std::string& fleet,
                               security::MemberRole usual_role);

// Throws Failure.
security::Authority open_authority(const Options& options);

// Seconds since 1970.
std::int64_t wall_seconds();
// "2026-11-27 00:42:10Z"
std::string date_text(std::int64_t seconds);

// Addresses by which other hosts may reach this one, IPv4 before IPv6; loopback if there is nothing
// else.
std::vector<std::string> own_addresses();
// For certificates of this host: its name and those addresses.
std::vector<std::string> own_names();
bool is_renewal_due(const security::Credentials& own);

// For errors of the folder of keys: their texts state file and remedy.
Failure key_failure(const tims::Error& error);
template <typename T>
T key_value(tims::Result<T> result) {
  if (!result) throw key_failure(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(result).value();
}

}  // namespace timsctl

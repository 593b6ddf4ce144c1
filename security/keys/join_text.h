// The one text that a robot needs to join a fleet: where the base is, which root it must prove, and
// a secret.
//
//   tims-join:10.9.1.1,base.local:2011/CODE
//
// CODE: base64url (RFC 4648, 5) of 16 bytes of the root's fingerprint, 16 bytes of the secret, and
// 2 bytes of the hash of both, which tell a typing error.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "security/crypto/digest.h"
#include "tims/result.h"

namespace tims::security {

inline constexpr std::uint16_t kJoinPort = 2011;  // TCP

struct JoinText {
  static constexpr std::size_t kHostsMax = 4;

  std::vector<std::string> hosts;  // names or addresses, IPv6 without brackets; 1 to 4
  std::uint16_t port = kJoinPort;
  std::array<std::byte, 16> root{};    // beginning of the root's fingerprint
  std::array<std::byte, 16> secret{};  // travels in this text only

  [[nodiscard]] std::string to_string() const;
  // kMalformed: the detail states what is wrong, never the secret.
  static Result<JoinText> parse(std::string_view text);
  bool operator==(const JoinText&) const = default;
};

// What the base keeps of a secret.
Digest hash_of_secret(View secret);
// The name of a token for people and files: the beginning of that hash, 8 hex digits.
std::string token_id(const Digest& hash);
// Proves the secret in one TLS connection: `keys` are exported from it.
Digest join_proof(const Digest& hash, View keys);

}  // namespace tims::security

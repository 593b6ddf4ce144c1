// Random bytes, hashes, and keys derived from secrets (HKDF, RFC 5869, labels as in RFC 8446).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "security/crypto/handles.h"

namespace tims::security {

using Digest = std::array<std::byte, 32>;

// Fills with bytes that nobody can predict. A system without random numbers ends the program: a key
// made without them would be worse.
void fill_random(std::span<std::byte> out);
std::uint64_t random_number();

Digest sha256(View data);
Digest hmac_sha256(View key, View data);

// Compares in a time that does not tell where the difference lies. Different sizes are unequal.
bool equal_secretly(View a, View b);
// Overwrites a secret; the compiler does not leave it out.
void wipe(std::span<std::byte> secret);

// HKDF-Extract and HKDF-Expand with SHA-256. `out` has at most 255 * 32 bytes.
Digest hkdf_extract(View salt, View secret);
void hkdf_expand(const Digest& secret, View info, std::span<std::byte> out);
// HKDF-Expand-Label of TLS 1.3: the label gets the prefix "tls13 "; label and context have at most
// 200 bytes together.
void hkdf_expand_label(const Digest& secret, std::string_view label, View context,
                       std::span<std::byte> out);

}  // namespace tims::security

// Sealing and opening in place (AEAD, RFC 5116). After the first key of a suite nothing is
// allocated: not for a datagram, nor for a further key.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "security/crypto/handles.h"

namespace tims::security {

enum class Suite : std::uint8_t { kAes128Gcm, kChaCha20Poly1305 };
constexpr std::size_t key_bytes(Suite suite) { return suite == Suite::kAes128Gcm ? 16 : 32; }

// Whether this processor has instructions for AES: without them ChaCha20 is several times faster.
bool has_aes();

inline constexpr std::size_t kTagBytes = 16;
using Nonce = std::array<std::byte, 12>;

// One key for one direction. A nonce is never used twice with a key. Not for several threads.
class Aead {
 public:
  enum class Direction : std::uint8_t { kSeal, kOpen };

  explicit Aead(Direction direction);

  // `key` has key_bytes(suite) bytes. False: wrong size, or OpenSSL lacks the suite.
  [[nodiscard]] bool set_key(Suite suite, View key);
  [[nodiscard]] bool has_key() const { return has_key_; }

  // Encrypts `text` in place and writes the tag. `aad` is authenticated only. False: no key.
  [[nodiscard]] bool seal(const Nonce& nonce, View aad, std::span<std::byte> text,
                          std::span<std::byte, kTagBytes> tag);
  // Decrypts `text` in place. False: forged or damaged; then `text` has no meaning.
  [[nodiscard]] bool open(const Nonce& nonce, View aad, std::span<std::byte> text,
                          std::span<const std::byte, kTagBytes> tag);

 private:
  [[nodiscard]] bool start(const Nonce& nonce, View aad, const ossl_param_st* parameters);
  [[nodiscard]] bool run(std::span<std::byte> text);

  Direction direction_;
  Suite suite_ = Suite::kAes128Gcm;
  bool has_key_ = false;
  Handle<evp_cipher_st> cipher_;
  Handle<evp_cipher_ctx_st> context_;
};

}  // namespace tims::security

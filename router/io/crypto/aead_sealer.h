// Seals datagrams with AES-128-GCM or ChaCha20-Poly1305. Keys follow from the secrets of a
// handshake as in QUIC (RFC 9001, section 5.1) with labels of our own: "tims key", "tims iv", and
// "tims ku" for the secret of the next phase.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "router/link/seal.h"
#include "security/crypto/aead.h"
#include "security/crypto/digest.h"

namespace tims::io {

class AeadSealer final : public link::Sealer {
 public:
  using Secret = security::Digest;
  AeadSealer(security::Suite suite, const Secret& sending, const Secret& receiving);
  AeadSealer(const AeadSealer&) = delete;
  AeadSealer& operator=(const AeadSealer&) = delete;
  ~AeadSealer() override;

  void seal(std::uint64_t number, std::span<const std::byte> header, std::span<std::byte> text,
            std::span<std::byte, kTagSize> tag) override;
  [[nodiscard]] bool open(Phase phase, std::uint64_t number, std::span<const std::byte> header,
                          std::span<std::byte> text,
                          std::span<const std::byte, kTagSize> tag) override;
  void next_sending_phase() override;
  void next_receiving_phase() override;
  [[nodiscard]] std::string_view suite() const override;

 private:
  // One direction in one phase.
  struct Keys {
    explicit Keys(security::Aead::Direction direction) : aead(direction) {}
    // The next phase of `before`, or the first one.
    void follow(security::Suite suite, const Secret& before);
    void begin(security::Suite suite, const Secret& first);

    Secret secret{};
    security::Nonce iv{};
    security::Aead aead;
  };

  security::Suite suite_;
  Keys sending_{security::Aead::Direction::kSeal};
  // Of three phases; which is which changes.
  std::array<Keys, 3> receiving_{Keys{security::Aead::Direction::kOpen},
                                 Keys{security::Aead::Direction::kOpen},
                                 Keys{security::Aead::Direction::kOpen}};
  std::size_t current_ = 1;  // the former phase is before it, the next one behind it, in a ring
};

}  // namespace tims::io

// What seals a link comes from outside, through two interfaces: a Handshaker proves who the other
// router is and agrees on secrets with it, and a Sealer encrypts datagrams with them. Links without
// keys have neither. router/io/crypto has them made of TLS 1.3 and its AEADs, tests/sim has
// stand-ins.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/types.h"

namespace tims::link {

// The secrets of one handshake, for both directions. In each direction the keys of a phase follow
// from those of the phase before; both begin with phase 0.
class Sealer : public core::Interface {
 public:
  static constexpr std::size_t kTagSize = 16;

  // Encrypts `text` in place with the sending keys, and writes the tag behind it into `tag`.
  // `number` is used once. `header` is authenticated and stays in the clear.
  virtual void seal(std::uint64_t number, std::span<const std::byte> header,
                    std::span<std::byte> text, std::span<std::byte, kTagSize> tag) = 0;
  enum class Phase : std::uint8_t { kFormer, kCurrent, kNext };
  // Decrypts in place with the receiving keys of this phase. False: not from the other router;
  // `text` is then undefined.
  [[nodiscard]] virtual bool open(Phase phase, std::uint64_t number,
                                  std::span<const std::byte> header, std::span<std::byte> text,
                                  std::span<const std::byte, kTagSize> tag) = 0;
  virtual void next_sending_phase() = 0;
  virtual void next_receiving_phase() = 0;
  // For reports: "AES-128-GCM".
  [[nodiscard]] virtual std::string_view suite() const = 0;
};

// The router that a certificate names.
struct PeerName {
  core::Role role = core::Role::kSystem;
  std::uint16_t system = 0;
  std::uint16_t id = 0;
  std::string name{};                    // for people
  std::vector<std::byte> certificate{};  // as lists of the fleet name it
  std::vector<std::byte> issuer{};       // the certificate of who has signed it, DER
};

// What the fleet's newest list makes of a certificate.
enum class Standing : std::uint8_t {
  kGood,
  kRevoked,
  kOldRoot,  // it comes from a root that is believed no longer
};

// The other router, proven by a handshake. Without keys there is no sealer and no certificate.
struct Verified {
  std::unique_ptr<Sealer> sealer{};
  PeerName peer{};
};

// What a handshake has produced since the last report of it.
struct HandshakeProgress {
  std::uint64_t handshake = 0;       // its number
  std::vector<std::byte> to_send{};  // to be carried to the other side, reliably and in order
  Verified verified{};               // has a sealer once: when the other side is verified
  std::vector<std::vector<std::byte>> messages{};  // of the verified other side
  std::string failure{};  // not empty: the handshake has ended, for this reason
};

// Runs handshakes, elsewhere and later: each call returns at once, and its result is passed to
// Links::on_handshake().
class Handshaker : public core::Interface {
 public:
  enum class Side : std::uint8_t { kConnects, kAccepts };
  // `binding`: both sides must have the same, otherwise their secrets differ.
  virtual void begin(std::uint64_t handshake, Side side, std::span<const std::byte> binding) = 0;
  // Bytes of the other side, in order.
  virtual void receive(std::uint64_t handshake, std::span<const std::byte> bytes) = 0;
  // A message for the other side, which receives it when both are verified.
  virtual void send(std::uint64_t handshake, std::span<const std::byte> message) = 0;
  virtual void end(std::uint64_t handshake) = 0;
};

}  // namespace tims::link

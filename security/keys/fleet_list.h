// What the authority of a fleet tells all members: whose certificates are revoked, and which roots
// are to be believed. Signed, with a number that only rises: of two lists the higher one counts.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "security/crypto/certificate.h"

namespace tims::security {

// By serial number and by public key: a certificate that somebody encodes or signs anew for a
// revoked key is revoked, too.
struct Revoked {
  std::array<std::byte, 16> serial{};  // the last 16 bytes of the number, zeros before it
  Digest public_key{};
  auto operator<=>(const Revoked&) const = default;
  static Revoked of(const Certificate& certificate);
  // For who keeps many, without their certificates: parsing one takes longer than all the rest.
  [[nodiscard]] Bytes to_bytes() const;
  static std::optional<Revoked> from_bytes(View bytes);
};

class FleetList {
 public:
  static constexpr std::size_t kBytesMax = 1 << 20;
  static constexpr std::size_t kEntriesMax = 20000;
  static constexpr std::size_t kRootsMax = 8;

  std::uint64_t number = 0;
  std::int64_t made = 0;  // seconds since 1970
  std::string fleet;
  std::vector<Certificate> roots;  // at least one

  void revoke(const Certificate& certificate);
  [[nodiscard]] bool revokes(const Certificate& certificate) const {
    return revokes(Revoked::of(certificate));
  }
  [[nodiscard]] bool revokes(const Revoked& entry) const;
  [[nodiscard]] std::size_t size() const { return revoked_.size(); }

  // The list with the issuing certificate and its signature. kTooBig: more than the limits above.
  [[nodiscard]] Result<Bytes> sign(const Certificate& issuing, const PrivateKey& key) const;

  // Only lists whose signature is right and whose signer is one of `trusted` or issued by one of
  // them. The detail of an error states what is wrong.
  static Result<FleetList> open(View bytes, const std::vector<Certificate>& trusted,
                                std::string_view fleet);
  // The number of a list, without looking at its signature: whether it is worth opening. 0: no
  // list.
  static std::uint64_t number_of(View bytes);

 private:
  std::set<Revoked> revoked_;
  std::set<Digest> revoked_keys_;
  std::set<std::array<std::byte, 16>> revoked_serials_;
};

}  // namespace tims::security

#include "router/io/crypto/aead_sealer.h"

#include <algorithm>

namespace tims::io {
namespace {

static_assert(link::Sealer::kTagSize == security::kTagBytes);

constexpr std::size_t kFormer = 2;  // steps along the ring of three
constexpr std::size_t kNext = 1;

// The number of a packet is used once, so a nonce is, too (RFC 9001, section 5.3).
security::Nonce nonce_of(security::Nonce nonce, std::uint64_t number) {
  for (std::size_t i = 0; i < sizeof number; ++i)
    nonce[nonce.size() - 1 - i] ^= static_cast<std::byte>(number >> (8 * i) & 0xFF);
  return nonce;
}

}  // namespace

void AeadSealer::Keys::begin(security::Suite suite, const Secret& first) {
  secret = first;
  std::array<std::byte, 32> key{};
  const auto used = std::span(key).first(security::key_bytes(suite));
  security::hkdf_expand_label(secret, "tims key", {}, used);
  security::hkdf_expand_label(secret, "tims iv", {}, iv);
  // Without a key nothing is sealed and nothing opens.
  (void)aead.set_key(suite, used);
  security::wipe(key);
}

void AeadSealer::Keys::follow(security::Suite suite, const Secret& before) {
  Secret after{};
  security::hkdf_expand_label(before, "tims ku", {}, after);
  begin(suite, after);
  security::wipe(after);
}

AeadSealer::AeadSealer(security::Suite suite, const Secret& sending, const Secret& receiving)
    : suite_(suite) {
  sending_.begin(suite, sending);
  receiving_[current_].begin(suite, receiving);
  receiving_[current_ + kNext].follow(suite, receiving);
}

AeadSealer::~AeadSealer() {
  security::wipe(sending_.secret);
  for (Keys& keys : receiving_) security::wipe(keys.secret);
}

// A datagram that cannot be sealed must not go out in the clear.
void AeadSealer::seal(std::uint64_t number, std::span<const std::byte> header,
                      std::span<std::byte> text, std::span<std::byte, kTagSize> tag) {
  if (sending_.aead.seal(nonce_of(sending_.iv, number), header, text, tag)) return;
  std::ranges::fill(text, std::byte{0});
  std::ranges::fill(tag, std::byte{0});
}

bool AeadSealer::open(Phase phase, std::uint64_t number, std::span<const std::byte> header,
                      std::span<std::byte> text, std::span<const std::byte, kTagSize> tag) {
  const std::size_t step = phase == Phase::kFormer ? kFormer : phase == Phase::kNext ? kNext : 0;
  Keys& keys = receiving_[(current_ + step) % receiving_.size()];
  return keys.aead.has_key() && keys.aead.open(nonce_of(keys.iv, number), header, text, tag);
}

void AeadSealer::next_sending_phase() {
  const Secret before = sending_.secret;
  sending_.follow(suite_, before);
}

// The next phase is derived ahead: a datagram that opens with it costs no more than others.
void AeadSealer::next_receiving_phase() {
  current_ = (current_ + kNext) % receiving_.size();
  receiving_[(current_ + kNext) % receiving_.size()].follow(suite_, receiving_[current_].secret);
}

std::string_view AeadSealer::suite() const {
  return suite_ == security::Suite::kAes128Gcm ? "AES-128-GCM" : "ChaCha20-Poly1305";
}

}  // namespace tims::io

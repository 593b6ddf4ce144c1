#include "tests/bench/sealing.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "libtims/os/clock.h"
#include "router/io/crypto/aead_sealer.h"
#include "router/link/session_keys.h"
#include "tests/bench/limits.h"

namespace tims::bench {
namespace {

// With an MTU of 1500 bytes.
constexpr std::size_t kSealedDatagram = 1472;
constexpr std::size_t kSealedText =
    kSealedDatagram - link::kDataHeaderSize - link::Sealer::kTagSize;
constexpr std::size_t kSealedTrain = 44;  // of datagrams that are offered to the socket together

std::uint64_t datagrams_of(const Plan& plan) {
  return (plan.payload + kSealedText - 1) / kSealedText;
}

std::span<std::byte> at(std::vector<std::byte>& train, std::uint64_t number) {
  return std::span(train).subspan(number % kSealedTrain * kSealedDatagram, kSealedDatagram);
}

}  // namespace

bool seal_datagrams(const Plan& plan) {
  link::SessionKeys keys;
  keys.begin(os::now(),
             std::make_unique<io::AeadSealer>(security::Suite::kAes128Gcm, io::AeadSealer::Secret{},
                                              io::AeadSealer::Secret{}));
  std::vector<std::byte> train(kSealedTrain * kSealedDatagram);
  std::uint64_t number = 0;
  measure_passes(plan, [&]() -> std::uint64_t {
    const Time now = os::now();
    for (std::uint64_t i = datagrams_of(plan); i > 0; --i, ++number)
      keys.seal(now, 1, number, at(train, number));
    return 1;
  });
  return true;
}

bool encrypt_alone(const Plan& plan) {
  security::Aead aead(security::Aead::Direction::kSeal);
  const std::array<std::byte, 16> key{};
  if (!aead.set_key(security::Suite::kAes128Gcm, key)) return false;
  std::vector<std::byte> train(kSealedTrain * kSealedDatagram);
  security::Nonce nonce{};
  std::uint64_t number = 0;
  bool sealed = true;
  measure_passes(plan, [&]() -> std::uint64_t {
    for (std::uint64_t i = datagrams_of(plan); i > 0; --i, ++number) {
      std::memcpy(nonce.data(), &number, sizeof number);
      const auto datagram = at(train, number);
      sealed =
          aead.seal(nonce, {}, datagram.first(kSealedText), datagram.last<security::kTagBytes>()) &&
          sealed;
    }
    return 1;
  });
  return sealed;
}

}  // namespace tims::bench

#include "security/crypto/digest.h"

#include <algorithm>
#include <climits>
#include <cstdlib>

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

namespace tims::security {
namespace {

const unsigned char* octets(View bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* octets(std::span<std::byte> bytes) {
  return reinterpret_cast<unsigned char*>(bytes.data());
}

}  // namespace

void fill_random(std::span<std::byte> out) {
  while (!out.empty()) {
    const std::size_t size = std::min<std::size_t>(out.size(), INT_MAX);
    if (RAND_bytes(octets(out), static_cast<int>(size)) != 1) std::abort();
    out = out.subspan(size);
  }
}

std::uint64_t random_number() {
  std::uint64_t number = 0;
  fill_random(std::as_writable_bytes(std::span(&number, 1)));
  return number;
}

Digest sha256(View data) {
  Digest digest{};
  SHA256(octets(data), data.size(), octets(std::span<std::byte>(digest)));
  return digest;
}

Digest hmac_sha256(View key, View data) {
  Digest digest{};
  // A null key would mean "that of the last call".
  static constexpr std::byte kNone{};
  const View used = key.empty() ? View(&kNone, 0) : key;
  HMAC(EVP_sha256(), used.data(), static_cast<int>(used.size()), octets(data), data.size(),
       octets(std::span<std::byte>(digest)), nullptr);
  return digest;
}

bool equal_secretly(View a, View b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

void wipe(std::span<std::byte> secret) { OPENSSL_cleanse(secret.data(), secret.size()); }

Digest hkdf_extract(View salt, View secret) { return hmac_sha256(salt, secret); }

void hkdf_expand(const Digest& secret, View info, std::span<std::byte> out) {
  std::array<std::byte, 32 + 256 + 1> block{};
  const std::size_t used = std::min<std::size_t>(info.size(), 256);
  std::size_t former =
      0;  // bytes of the block before, which each block after the first begins with
  Digest digest{};
  for (unsigned char round = 1; !out.empty(); ++round) {
    std::copy_n(digest.begin(), former, block.begin());
    std::copy_n(info.begin(), used, block.begin() + static_cast<std::ptrdiff_t>(former));
    block[former + used] = std::byte{round};
    digest = hmac_sha256(secret, View(block).first(former + used + 1));
    const std::size_t taken = std::min(out.size(), digest.size());
    std::copy_n(digest.begin(), taken, out.begin());
    out = out.subspan(taken);
    former = digest.size();
  }
  wipe(digest);
  wipe(block);
}

void hkdf_expand_label(const Digest& secret, std::string_view label, View context,
                       std::span<std::byte> out) {
  constexpr std::string_view kPrefix = "tls13 ";
  std::array<std::byte, 256> info{};
  auto end = info.begin();
  *end++ = static_cast<std::byte>(out.size() >> 8);
  *end++ = static_cast<std::byte>(out.size());
  *end++ = static_cast<std::byte>(kPrefix.size() + label.size());
  end = std::ranges::copy(view_of(kPrefix), end).out;
  end = std::ranges::copy(view_of(label).first(std::min<std::size_t>(label.size(), 120)), end).out;
  *end++ = static_cast<std::byte>(context.size());
  end = std::ranges::copy(context.first(std::min<std::size_t>(context.size(), 100)), end).out;
  hkdf_expand(secret, View(info.begin(), end), out);
}

}  // namespace tims::security

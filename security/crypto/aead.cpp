#include "security/crypto/aead.h"

#include <algorithm>
#include <array>
#include <new>

#include <openssl/core_names.h>
#include <openssl/evp.h>
#include <openssl/params.h>
#if defined(__aarch64__)
#include <sys/auxv.h>
#endif

namespace tims::security {
namespace {

const unsigned char* octets(const std::byte* bytes) {
  return reinterpret_cast<const unsigned char*>(bytes);
}
unsigned char* octets(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }

// The tag as OpenSSL's ciphers take it. EVP_CIPHER_CTX_ctrl() translates its command into the same,
// which costs a twentieth of sealing a datagram.
std::array<OSSL_PARAM, 2> tag_parameter(std::span<std::byte, kTagBytes> tag) {
  return {OSSL_PARAM_construct_octet_string(OSSL_CIPHER_PARAM_AEAD_TAG, tag.data(), tag.size()),
          OSSL_PARAM_construct_end()};
}

}  // namespace

bool has_aes() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("aes") != 0;
#elif defined(__aarch64__)
  constexpr unsigned long kHwcapAes = 1UL << 3;
  return (getauxval(AT_HWCAP) & kHwcapAes) != 0;
#else
  return false;
#endif
}

Aead::Aead(Direction direction) : direction_(direction), context_(EVP_CIPHER_CTX_new()) {
  if (!context_) throw std::bad_alloc();
}

bool Aead::set_key(Suite suite, View key) {
  if (key.size() != key_bytes(suite)) return false;
  const bool other = !cipher_ || suite != suite_;
  if (other) {
    const char* const name = suite == Suite::kAes128Gcm ? "AES-128-GCM" : "ChaCha20-Poly1305";
    cipher_.reset(EVP_CIPHER_fetch(nullptr, name, nullptr));
    suite_ = suite;
  }
  const int encrypt = direction_ == Direction::kSeal ? 1 : 0;
  has_key_ = cipher_ && EVP_CipherInit_ex2(context_.get(), other ? cipher_.get() : nullptr,
                                           octets(key.data()), nullptr, encrypt, nullptr) == 1;
  return has_key_;
}

bool Aead::start(const Nonce& nonce, View aad, const OSSL_PARAM* parameters) {
  int size = 0;
  return has_key_ &&
         EVP_CipherInit_ex2(context_.get(), nullptr, nullptr, octets(nonce.data()), -1,
                            parameters) == 1 &&
         (aad.empty() || EVP_CipherUpdate(context_.get(), nullptr, &size, octets(aad.data()),
                                          static_cast<int>(aad.size())) == 1);
}

bool Aead::run(std::span<std::byte> text) {
  int size = 0;
  return text.empty() ||
         (EVP_CipherUpdate(context_.get(), octets(text.data()), &size, octets(text.data()),
                           static_cast<int>(text.size())) == 1 &&
          static_cast<std::size_t>(size) == text.size());
}

bool Aead::seal(const Nonce& nonce, View aad, std::span<std::byte> text,
                std::span<std::byte, kTagBytes> tag) {
  int size = 0;
  unsigned char nothing = 0;
  std::array parameters = tag_parameter(tag);
  return start(nonce, aad, nullptr) && run(text) &&
         EVP_CipherFinal_ex(context_.get(), &nothing, &size) == 1 &&
         EVP_CIPHER_CTX_get_params(context_.get(), parameters.data()) == 1;
}

bool Aead::open(const Nonce& nonce, View aad, std::span<std::byte> text,
                std::span<const std::byte, kTagBytes> tag) {
  std::array<std::byte, kTagBytes> expected{};  // OpenSSL takes no constant
  std::ranges::copy(tag, expected.begin());
  int size = 0;
  unsigned char nothing = 0;
  const std::array parameters = tag_parameter(expected);
  return start(nonce, aad, parameters.data()) && run(text) &&
         EVP_CipherFinal_ex(context_.get(), &nothing, &size) == 1;
}

}  // namespace tims::security

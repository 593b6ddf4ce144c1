#include "security/crypto/aead.h"

#include <algorithm>
#include <new>

#include <openssl/evp.h>
#if defined(__aarch64__)
#include <sys/auxv.h>
#endif

namespace tims::security {
namespace {

const unsigned char* octets(const std::byte* bytes) {
  return reinterpret_cast<const unsigned char*>(bytes);
}
unsigned char* octets(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }

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

bool Aead::start(const Nonce& nonce, View aad) {
  int size = 0;
  return has_key_ &&
         EVP_CipherInit_ex2(context_.get(), nullptr, nullptr, octets(nonce.data()), -1, nullptr) ==
             1 &&
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
  return start(nonce, aad) && run(text) &&
         EVP_CipherFinal_ex(context_.get(), &nothing, &size) == 1 &&
         EVP_CIPHER_CTX_ctrl(context_.get(), EVP_CTRL_AEAD_GET_TAG, kTagBytes, tag.data()) == 1;
}

bool Aead::open(const Nonce& nonce, View aad, std::span<std::byte> text,
                std::span<const std::byte, kTagBytes> tag) {
  std::array<std::byte, kTagBytes> expected{};  // OpenSSL takes no constant
  std::ranges::copy(tag, expected.begin());
  int size = 0;
  unsigned char nothing = 0;
  return start(nonce, aad) &&
         EVP_CIPHER_CTX_ctrl(context_.get(), EVP_CTRL_AEAD_SET_TAG, kTagBytes, expected.data()) ==
             1 &&
         run(text) && EVP_CipherFinal_ex(context_.get(), &nothing, &size) == 1;
}

}  // namespace tims::security

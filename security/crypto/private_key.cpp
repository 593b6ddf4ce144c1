#include "security/crypto/private_key.h"

#include <algorithm>
#include <array>
#include <climits>

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include "security/crypto/public_key.h"

namespace tims::security {
namespace {

// Never asks at the terminal: keys with a passphrase could not be used by a service.
int no_passphrase(char*, int, int, void*) { return -1; }

}  // namespace

Handle<bio_st> reading(std::string_view text) {
  return Handle<bio_st>(
      BIO_new_mem_buf(text.data(), static_cast<int>(std::min<std::size_t>(text.size(), INT_MAX))));
}

std::string written(bio_st* bio) {
  const char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return size <= 0 ? std::string() : std::string(data, static_cast<std::size_t>(size));
}

bool is_p256(const evp_pkey_st* key) {
  std::array<char, 32> group{};
  std::size_t size = 0;
  return EVP_PKEY_is_a(key, "EC") == 1 &&
         EVP_PKEY_get_group_name(key, group.data(), group.size(), &size) == 1 &&
         std::string_view(group.data(), size) == "prime256v1";
}

Digest hash_of_public_key(evp_pkey_st* key) {
  unsigned char* encoded = nullptr;
  const int size = i2d_PUBKEY(key, &encoded);
  if (size <= 0) return {};
  const Digest digest = sha256(std::as_bytes(std::span(encoded, static_cast<std::size_t>(size))));
  OPENSSL_free(encoded);
  return digest;
}

bool verify_signature(evp_pkey_st* key, View data, View signature) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        &EVP_MD_CTX_free);
  return context && EVP_DigestVerifyInit(context.get(), nullptr, EVP_sha256(), nullptr, key) == 1 &&
         EVP_DigestVerify(context.get(), reinterpret_cast<const unsigned char*>(signature.data()),
                          signature.size(), reinterpret_cast<const unsigned char*>(data.data()),
                          data.size()) == 1;
}

Result<PrivateKey> PrivateKey::generate() {
  Handle<evp_pkey_st> key(EVP_EC_gen("P-256"));
  if (!key) return crypto_error("cannot make a key");
  return PrivateKey(std::move(key));
}

Result<PrivateKey> PrivateKey::from_pem(std::string_view pem) {
  const Handle<bio_st> bio = reading(pem);
  Handle<evp_pkey_st> key(PEM_read_bio_PrivateKey(bio.get(), nullptr, &no_passphrase, nullptr));
  if (!key) return crypto_error("no private key (PEM, PKCS#8, without a passphrase)");
  if (!is_p256(key.get()))
    return Error(Errc::kMalformed, "the private key is not of the curve P-256");
  return PrivateKey(std::move(key));
}

std::string PrivateKey::to_pem() const {
  const Handle<bio_st> bio(BIO_new(BIO_s_secmem()));
  if (PEM_write_bio_PKCS8PrivateKey(bio.get(), key_.get(), nullptr, nullptr, 0, nullptr, nullptr) !=
      1)
    return {};
  return written(bio.get());
}

Result<Bytes> PrivateKey::sign(View data) const {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        &EVP_MD_CTX_free);
  std::size_t size = 0;
  const auto* octets = reinterpret_cast<const unsigned char*>(data.data());
  if (!context ||
      EVP_DigestSignInit(context.get(), nullptr, EVP_sha256(), nullptr, key_.get()) != 1 ||
      EVP_DigestSign(context.get(), nullptr, &size, octets, data.size()) != 1)
    return crypto_error("cannot sign");
  Bytes signature(size);
  if (EVP_DigestSign(context.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                     octets, data.size()) != 1)
    return crypto_error("cannot sign");
  signature.resize(size);
  return signature;
}

Digest PrivateKey::public_key_hash() const { return hash_of_public_key(key_.get()); }

}  // namespace tims::security

// A private key: ECDSA with the curve P-256, which browsers and DDS-Security take as well.
#pragma once

#include <string>
#include <string_view>

#include "security/crypto/digest.h"
#include "security/crypto/handles.h"

namespace tims::security {

// Copies share one key.
class PrivateKey {
 public:
  static Result<PrivateKey> generate();
  // PKCS#8 or another form that an OpenSSL provider reads (tpm2). kMalformed: no key, or a key that
  // is not of P-256.
  static Result<PrivateKey> from_pem(std::string_view pem);

  [[nodiscard]] std::string to_pem() const;  // PKCS#8, not encrypted
  // ECDSA over the SHA-256 hash, DER.
  [[nodiscard]] Result<Bytes> sign(View data) const;
  // SHA-256 of the public key (SubjectPublicKeyInfo, DER).
  [[nodiscard]] Digest public_key_hash() const;

  [[nodiscard]] evp_pkey_st* native() const { return key_.get(); }

 private:
  explicit PrivateKey(Handle<evp_pkey_st> key) : key_(std::move(key)) {}

  std::shared_ptr<evp_pkey_st> key_;
};

}  // namespace tims::security

// X.509 certificates and requests for them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "security/crypto/digest.h"
#include "security/crypto/handles.h"
#include "security/crypto/private_key.h"

namespace tims::security {

// A certificate is public; copies share one object.
class Certificate {
 public:
  // The certificate's own DER encoding, nothing behind it. At most 16 kB.
  static Result<Certificate> from_der(View der);
  // All certificates of a PEM text, at least one, at most 16. Other blocks are an error.
  static Result<std::vector<Certificate>> from_pem(std::string_view pem);
  // Shares an object of OpenSSL.
  static Certificate share(x509_st* certificate);

  [[nodiscard]] std::string to_pem() const;
  [[nodiscard]] Bytes to_der() const;
  [[nodiscard]] Digest fingerprint() const;      // SHA-256 of the DER encoding
  [[nodiscard]] Digest public_key_hash() const;  // SHA-256 of SubjectPublicKeyInfo
  [[nodiscard]] std::string serial() const;      // hex digits, lower case, without leading zeros
  [[nodiscard]] std::string subject() const;     // common name, for people only

  // All URIs and host names of the subject, as they stand there, with NUL if there is one.
  [[nodiscard]] std::vector<std::string> uris() const;
  [[nodiscard]] std::vector<std::string> host_names() const;

  // Seconds since 1970. INT64_MIN and INT64_MAX if the date cannot be read.
  [[nodiscard]] std::int64_t not_before() const;
  [[nodiscard]] std::int64_t not_after() const;

  [[nodiscard]] bool is_authority() const;  // may sign certificates
  [[nodiscard]] bool is_self_signed() const;
  [[nodiscard]] bool belongs_to(const PrivateKey& key) const;
  [[nodiscard]] bool has_signed(const Certificate& other) const;
  // ECDSA with SHA-256.
  [[nodiscard]] bool verify(View data, View signature) const;

  [[nodiscard]] x509_st* native() const { return certificate_.get(); }
  bool operator==(const Certificate& other) const { return fingerprint() == other.fingerprint(); }

 private:
  friend struct Issue;
  explicit Certificate(Handle<x509_st> certificate) : certificate_(std::move(certificate)) {}
  [[nodiscard]] std::vector<std::string> names(int kind) const;

  std::shared_ptr<x509_st> certificate_;
};

std::string to_pem(const std::vector<Certificate>& certificates);

// A request for a certificate (PKCS#10): a public key and the names that are wanted, signed with
// the private key.
class CertificateRequest {
 public:
  static Result<CertificateRequest> make(const PrivateKey& key,
                                         const std::vector<std::string>& uris);
  // kMalformed also if its signature is wrong or its key is not of P-256. At most 16 kB.
  static Result<CertificateRequest> from_pem(std::string_view pem);

  [[nodiscard]] std::string to_pem() const;
  [[nodiscard]] std::vector<std::string> uris() const;
  [[nodiscard]] Digest public_key_hash() const;

  [[nodiscard]] X509_req_st* native() const { return request_.get(); }

 private:
  explicit CertificateRequest(Handle<X509_req_st> request) : request_(std::move(request)) {}

  std::shared_ptr<X509_req_st> request_;
};

// What a new certificate says.
struct Issue {
  enum class Kind : std::uint8_t { kRoot, kIssuing, kMember };

  Kind kind = Kind::kMember;
  std::string subject;  // common name, for people
  std::vector<std::string> uris;
  std::vector<std::string> host_names;
  std::int64_t not_before = 0;  // seconds since 1970
  std::int64_t not_after = 0;

  // Signed by `key` whose certificate is `issuer`.
  [[nodiscard]] Result<Certificate> sign(const CertificateRequest& request,
                                         const Certificate& issuer, const PrivateKey& key) const;
  [[nodiscard]] Result<Certificate> sign(const PrivateKey& subject_key, const Certificate& issuer,
                                         const PrivateKey& key) const;
  [[nodiscard]] Result<Certificate> self_sign(const PrivateKey& key) const;

 private:
  [[nodiscard]] Result<Certificate> made(evp_pkey_st* subject_key, x509_st* issuer,
                                         evp_pkey_st* key) const;
};

}  // namespace tims::security

// How TLS connections of one kind are made: versions, suites, own certificate, whom to believe.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "security/crypto/certificate.h"
#include "security/crypto/handles.h"

namespace tims::security {

// Why a certificate is not accepted although its chain is right. `code` becomes the alert by which
// the other side learns of it.
struct Refusal {
  enum class Code : std::uint8_t { kRevoked, kExpired, kNotYetValid, kIdentity, kOldList };
  Code code = Code::kIdentity;
  std::string text;
};

struct TlsSettings {
  enum class Side : std::uint8_t { kServer, kClient };
  // kOptional: a server asks for a certificate; one that is sent must be right.
  enum class PeerCertificate : std::uint8_t { kRequired, kOptional, kNone };

  Side side = Side::kClient;
  PeerCertificate peer = PeerCertificate::kRequired;
  bool browsers = false;           // also TLS 1.2 and P-256, as browsers and their proxies may need
  std::vector<Certificate> chain;  // own certificate first; may be empty for a client
  std::optional<PrivateKey> key;
  std::vector<Certificate> trusted;
  // In addition to `trusted`: a self-signed certificate of the peer's chain whose fingerprint
  // begins with these bytes.
  std::optional<std::array<std::byte, 16>> trusted_fingerprint;
  // Called for each certificate of a chain that is right except for its dates, which OpenSSL does
  // not check; own certificate: depth 0. May be called by another thread than the context's.
  std::function<std::optional<Refusal>(const Certificate&, int depth)> judge;
};

// TLS 1.3, X25519, AES-128-GCM and ChaCha20-Poly1305 only, unless it is for browsers. No tickets,
// no early data, no middlebox mode; no certificate is sent that is not in `chain`. Copies share one
// context, which is not changed any more: other keys are another context.
class TlsContext {
 public:
  static Result<TlsContext> make(TlsSettings settings);

  [[nodiscard]] TlsSettings::Side side() const;
  // For asio::ssl::context, which releases it: SSL_CTX_up_ref() first. It may outlive this object.
  [[nodiscard]] ssl_ctx_st* native() const { return context_.get(); }

 private:
  explicit TlsContext(std::shared_ptr<ssl_ctx_st> context) : context_(std::move(context)) {}

  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace tims::security

#include "security/crypto/tls_context.h"

#include <algorithm>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509_vfy.h>

#include "security/crypto/aead.h"
#include "security/crypto/tls_session.h"

namespace tims::security {
namespace {

constexpr std::size_t kPeerChainBytesMax = 12 << 10;

struct Judge {
  TlsSettings settings;
};

// The context's settings live as long as the context.
void free_judge(void*, void* judge, CRYPTO_EX_DATA*, int, long, void*) {
  delete static_cast<Judge*>(judge);
}
int judge_index() {
  static const int index = SSL_CTX_get_ex_new_index(0, nullptr, nullptr, nullptr, &free_judge);
  return index;
}

int verify_code(Refusal::Code code) {
  switch (code) {
    case Refusal::Code::kRevoked:
      return X509_V_ERR_CERT_REVOKED;
    case Refusal::Code::kExpired:
      return X509_V_ERR_CERT_HAS_EXPIRED;
    case Refusal::Code::kNotYetValid:
      return X509_V_ERR_CERT_NOT_YET_VALID;
    case Refusal::Code::kIdentity:
    case Refusal::Code::kOldList:
      break;
  }
  return X509_V_ERR_APPLICATION_VERIFICATION;
}

// Adds the root with the expected fingerprint, if the peer has sent it, to those that are trusted.
void trust_fingerprint(X509_STORE_CTX* store, const std::array<std::byte, 16>& wanted,
                       STACK_OF(X509) * trusted) {
  STACK_OF(X509)* sent = X509_STORE_CTX_get0_untrusted(store);
  for (int i = 0; i < sk_X509_num(sent); ++i) {
    const Certificate certificate = Certificate::share(sk_X509_value(sent, i));
    if (!std::ranges::equal(View(certificate.fingerprint()).first(wanted.size()), wanted)) continue;
    if (certificate.is_self_signed()) sk_X509_push(trusted, certificate.native());
  }
}

// Chain by OpenSSL, then each of its certificates by the settings' judge.
int verify_chain(X509_STORE_CTX* store, void* argument) {
  const auto& settings = static_cast<const Judge*>(argument)->settings;
  const std::unique_ptr<STACK_OF(X509), void (*)(STACK_OF(X509)*)> trusted(
      sk_X509_new_null(), [](STACK_OF(X509) * stack) { sk_X509_free(stack); });
  for (const Certificate& one : settings.trusted) sk_X509_push(trusted.get(), one.native());
  if (settings.trusted_fingerprint)
    trust_fingerprint(store, *settings.trusted_fingerprint, trusted.get());
  X509_STORE_CTX_set0_trusted_stack(store, trusted.get());
  X509_VERIFY_PARAM_set_flags(X509_STORE_CTX_get0_param(store), X509_V_FLAG_NO_CHECK_TIME);
  if (X509_verify_cert(store) != 1) return 0;
  const STACK_OF(X509)* chain = X509_STORE_CTX_get0_chain(store);
  for (int depth = 0; settings.judge && depth < sk_X509_num(chain); ++depth) {
    const auto refusal = settings.judge(Certificate::share(sk_X509_value(chain, depth)), depth);
    if (!refusal) continue;
    X509_STORE_CTX_set_error(store, verify_code(refusal->code));
    X509_STORE_CTX_set_error_depth(store, depth);
    const auto* ssl = static_cast<ssl_st*>(
        X509_STORE_CTX_get_ex_data(store, SSL_get_ex_data_X509_STORE_CTX_idx()));
    if (std::string* reason = reason_of(ssl)) *reason = refusal->text;
    return 0;
  }
  return 1;
}

bool set_versions(ssl_ctx_st* context, const TlsSettings& settings) {
  // Without AES instructions ChaCha20 is wished for first; the server takes the client's wish.
  const char* suites = has_aes() ? "TLS_AES_128_GCM_SHA256:TLS_CHACHA20_POLY1305_SHA256"
                                 : "TLS_CHACHA20_POLY1305_SHA256:TLS_AES_128_GCM_SHA256";
  constexpr auto kSuites12 =
      "ECDHE-ECDSA-AES128-GCM-SHA256:ECDHE-ECDSA-CHACHA20-POLY1305:"
      "ECDHE-RSA-AES128-GCM-SHA256:ECDHE-RSA-CHACHA20-POLY1305";
  return SSL_CTX_set_min_proto_version(context,
                                       settings.browsers ? TLS1_2_VERSION : TLS1_3_VERSION) == 1 &&
         SSL_CTX_set_ciphersuites(context, suites) == 1 &&
         SSL_CTX_set_cipher_list(context, kSuites12) == 1 &&
         SSL_CTX_set1_groups_list(context, settings.browsers ? "X25519:P-256" : "X25519") == 1 &&
         (settings.browsers || SSL_CTX_set1_sigalgs_list(context, "ECDSA+SHA256") == 1);
}

bool set_certificate(ssl_ctx_st* context, const TlsSettings& settings) {
  if (settings.chain.empty() || !settings.key) return settings.side == TlsSettings::Side::kClient;
  if (SSL_CTX_use_certificate(context, settings.chain.front().native()) != 1 ||
      SSL_CTX_use_PrivateKey(context, settings.key->native()) != 1)
    return false;
  for (std::size_t i = 1; i < settings.chain.size(); ++i)
    if (SSL_CTX_add1_chain_cert(context, settings.chain[i].native()) != 1) return false;
  return true;
}

void set_habits(ssl_ctx_st* context) {
  SSL_CTX_set_options(context, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  SSL_CTX_clear_options(context, SSL_OP_ENABLE_MIDDLEBOX_COMPAT);
  SSL_CTX_set_mode(context, SSL_MODE_NO_AUTO_CHAIN | SSL_MODE_RELEASE_BUFFERS |
                                SSL_MODE_ENABLE_PARTIAL_WRITE |
                                SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(context, 0);
  SSL_CTX_set_max_early_data(context, 0);
  SSL_CTX_set_max_cert_list(context, kPeerChainBytesMax);
}

int verify_mode(const TlsSettings& settings) {
  switch (settings.peer) {
    case TlsSettings::PeerCertificate::kRequired:
      return SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT;
    case TlsSettings::PeerCertificate::kOptional:
      return SSL_VERIFY_PEER;
    case TlsSettings::PeerCertificate::kNone:
      break;
  }
  return SSL_VERIFY_NONE;
}

}  // namespace

Result<TlsContext> TlsContext::make(TlsSettings settings) {
  const bool server = settings.side == TlsSettings::Side::kServer;
  const std::shared_ptr<ssl_ctx_st> context(
      SSL_CTX_new(server ? TLS_server_method() : TLS_client_method()), Release{});
  if (!context) return crypto_error("TLS");
  if (!set_versions(context.get(), settings)) return crypto_error("TLS versions and suites");
  if (!set_certificate(context.get(), settings))
    return crypto_error("own certificate and private key do not fit together");
  set_habits(context.get());
  SSL_CTX_set_verify(context.get(), verify_mode(settings), nullptr);
  auto judge = std::make_unique<Judge>(Judge{std::move(settings)});
  if (SSL_CTX_set_ex_data(context.get(), judge_index(), judge.get()) != 1)
    return crypto_error("TLS");
  SSL_CTX_set_cert_verify_callback(context.get(), &verify_chain, judge.release());
  return TlsContext(context);
}

TlsSettings::Side TlsContext::side() const {
  return static_cast<const Judge*>(SSL_CTX_get_ex_data(context_.get(), judge_index()))
      ->settings.side;
}

}  // namespace tims::security
